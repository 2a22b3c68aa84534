"""The recipe of a script, from its file to the record of a job and the exports."""

from __future__ import annotations

import io
import json
from pathlib import Path

import pytest
from fakes.action_types import FakeActionTypes
from fakes.line import THREE, Line
from fakes.virtual_run import BY, VirtualRun

from bt_orchestrator.cli.main import main
from bt_orchestrator.model.codec import digest, from_record
from bt_orchestrator.model.jobs.job_commands import AddJobs, UpdateJob
from bt_orchestrator.model.jobs.job_record import JobRecord, record_of
from bt_orchestrator.model.jobs.order import Job, RecipeChoice
from bt_orchestrator.model.keeping.snapshot import state_from_plain, state_to_plain
from bt_orchestrator.model.script import MadeFrom, Script
from bt_orchestrator.model.status_words import script_words
from bt_orchestrator.script.script_file import parse_script
from bt_orchestrator.store.sqlite.store import SqliteStore
from bt_orchestrator.view.report.ended_jobs import JobFold, job_text
from bt_orchestrator.view.report.item.fold import ItemFold
from bt_orchestrator.view.report.xes_export import XesExport


def of_version(line: Line, version: int) -> Script:
    made_from = f'made_from: {{recipe: WM-100, version: {version}, cell_digest: "12"}}'
    return line.script(f'{made_from}\n{THREE}')


def jobs_of(run: VirtualRun) -> dict[str, JobRecord]:
    fold = JobFold()
    for record in run.records:
        fold.follow(from_record(record))
    return fold.jobs


@pytest.fixture
def line() -> Line:
    return Line()


@pytest.fixture
def run(line: Line) -> VirtualRun:
    """Jobs of two versions that come to the same script, one of no recipe, and a changed one."""
    run = line.begin()
    run.release(of_version(line, 1))
    scripts = {'K': of_version(line, 1), 'L': of_version(line, 2), 'M': line.script(THREE)}
    run.ask(AddJobs(tuple(Job(name, script, 1) for name, script in scripts.items()), BY))
    run.ask(UpdateJob(Job('M', of_version(line, 3), 1), BY))
    return run


def test_made_from_does_not_change_script_digest(line: Line) -> None:
    script = of_version(line, 1)
    assert script.made_from == MadeFrom('WM-100', 1, cell_digest='12')
    assert line.script(THREE).made_from is None
    assert digest(script) == digest(of_version(line, 2)) == digest(line.script(THREE))


def test_each_job_keeps_its_ordered_version(run: VirtualRun) -> None:
    versions = {'J': ('', None), 'K': ('WM-100', 1), 'L': ('WM-100', 2), 'M': ('WM-100', 3)}
    live = {job.job.id: (job.recipe, job.recipe_version) for job in run.state.jobs.values()}
    assert live == versions
    again = state_from_plain(run.state.cell, state_to_plain(run.state))
    assert {n: (row.recipe, row.recipe_version) for n, row in again.jobs.items()} == versions
    run.go(until=2e9)
    ended = {name: record_of(job) for name, job in run.state.ended.items()}
    for records in (jobs_of(run), ended):
        assert {n: (row.recipe, row.recipe_version) for n, row in records.items()} == versions
        assert {row.digest for row in records.values()} == {digest(run.job('J').job.script)}


def test_reports_and_exports_name_it(run: VirtualRun) -> None:
    run.go(until=2e9)
    text = '\n'.join(job_text(list(jobs_of(run).values()), with_items=False))
    assert [f'test from WM-100 version {n}' in text for n in (1, 2, 3, 4)] == [True] * 3 + [False]
    file = io.StringIO()
    export = XesExport(file)
    for record in run.records:
        export.write(json.dumps(record))
    export.close()
    traces = file.getvalue().split('<trace>')[1:]
    assert ['key="recipe" value="WM-100"' in part for part in traces] == [False, True, True, True]
    assert 'key="recipe_version" value="2"' in traces[2]


def test_statuses_messages_and_items_name_it(run: VirtualRun) -> None:
    run.go(until=2e9)
    jobs = {job.id: job for job in run.sim.status().jobs}
    assert script_words(jobs['L']) == 'test from WM-100 version 2'
    assert script_words(jobs['J']) == 'test'
    fold = ItemFold('L/1', 'L')
    for record in run.records:
        fold.follow(from_record(record))
    item = fold.history
    assert (item.script, item.recipe, item.recipe_version) == ('test', 'WM-100', 2)


def test_history_prints_what_a_job_ran(
    run: VirtualRun, line: Line, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    journal = tmp_path / 'journal.sqlite3'
    store = SqliteStore(journal)
    store.append([from_record(record) for record in run.records])
    store.close()
    for job in 'JK':
        words = ('history', '--journal', str(journal), '--job', job, '--script')
        assert main(words) == 0
        text = capsys.readouterr().out
        assert text.startswith(f'# The script that job {job} ran, by the journal')
        read = parse_script(text, 'text', line.cell, FakeActionTypes())
        assert digest(read) == digest(line.script(THREE))
    assert main(('history', '--journal', str(journal), '--script')) == 2
    assert 'say which: --job JOB' in capsys.readouterr().err


def test_change_of_other_terms_keeps_recipe_version(line: Line, run: VirtualRun) -> None:
    """Jobs of several versions have one script in common: what it was made from is any of them."""
    kept = UpdateJob(Job('L', of_version(line, 3), 7), BY, keeps_script=True)
    assert run.ask(kept).accepted
    live = run.state.jobs['L']
    assert (live.job.quantity, live.recipe_version) == (7, 2)


@pytest.mark.parametrize('name', ['job.queued', 'job.updated'])
def test_a_record_of_an_older_program_has_none(name: str) -> None:
    record = {'event': name, 'seq': 1, 'job': 'J', 'script': 's', 'digest': 'd', 'quantity': 1}
    event = from_record({**record, 'time': 0.0})
    assert vars(event)['recipe'] == ''
    assert vars(event)['recipe_version'] is None


def test_what_an_order_named_stays_with_its_job(line: Line) -> None:
    choice = RecipeChoice(('WM-100', 'WM-101'), 2, {'insert': 'component_3a'})
    run = line.begin()
    made = of_version(line, 2)
    run.ask(AddJobs((Job('K', made, 1, recipe=choice), Job('L', made, 1)), BY))
    queued = {record['job']: record for record in run.all('job.queued')}
    assert queued['K']['choice'] == {
        'recipes': ['WM-100', 'WM-101'],
        'version': 2,
        'bind': {'insert': 'component_3a'},
    }
    assert 'choice' not in queued['L']
    assert from_record(queued['K']).choice == choice  # type: ignore[attr-defined]
    assert run.state.jobs['K'].job.recipe == choice
    again = state_from_plain(run.state.cell, state_to_plain(run.state))
    assert again.jobs['K'].job.recipe == choice
    assert again.jobs['L'].job.recipe is None

    run.ask(UpdateJob(Job('K', made, 4, recipe=choice), BY))
    assert run.state.jobs['K'].job.recipe == choice
    run.ask(UpdateJob(Job('K', made, 4), BY))
    assert run.state.jobs['K'].job.recipe is None
