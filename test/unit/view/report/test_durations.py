"""How long tasks take against nominal, since when, and new times for the cell file."""

from __future__ import annotations

import json
import random
from collections.abc import Iterable
from contextlib import closing
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

import pytest
from fakes.action_types import FakeActionTypes
from fakes.day import Day, at
from fakes.shipped import REFERENCE_CELL

from bt_orchestrator.cli import bootstrap
from bt_orchestrator.cli.main import main
from bt_orchestrator.model import events as e
from bt_orchestrator.script.cell_file import parse_cell
from bt_orchestrator.script.writing.duration_edits import NotEditable, with_durations
from bt_orchestrator.store.sqlite.store import SqliteStore
from bt_orchestrator.view.report.account.period import Period
from bt_orchestrator.view.report.account.planned import us_of
from bt_orchestrator.view.report.duration_times import MOST_KEPT, Kind, Samples, TimesFold
from bt_orchestrator.view.report.durations import drift_of, durations, lines
from bt_orchestrator.view.report.reading import Reading

TYPES = FakeActionTypes()
MONDAY = datetime(2026, 5, 11)
TUESDAY = MONDAY + timedelta(days=8)
END = MONDAY + timedelta(days=12)


def attempts(
    component: str, name: str, took: Iterable[tuple[datetime, float]], *, fails: bool = False
) -> list[e.Event]:
    events: list[e.Event] = []
    for number, (begin, seconds) in enumerate(took):
        about: dict[str, Any] = {'job': 'J', 'section': 4, 'item': f'J/{number}', 'task': name}
        goal = {**about, 'attempt': 1, 'goal': 'g'}
        time = begin.timestamp()
        sent = e.TaskStarted(**goal, name=name, action='/a', component=component, time=time)
        kind = e.TaskFailed if fails else e.TaskSucceeded
        more: dict[str, Any] = {'reason': 'aborted'} if fails else {}
        events += [sent, kind(**goal, time=time + seconds, **more)]
    return events


def of_days(levels: dict[datetime, float], noise: float, per_day: int = 20) -> list[e.Event]:
    """Return attempts of twelve days: each takes the level of the last day named before it."""
    chance = random.Random(1)
    took = []
    for day in range(12):
        begin = MONDAY + timedelta(days=day, hours=8)
        level = next(s for since, s in reversed(levels.items()) if since <= begin)
        minutes = (begin + timedelta(minutes=n) for n in range(per_day))
        took += [(time, level + chance.gauss(0.0, noise)) for time in minutes]
    return attempts('component_3b', 'TASK_B', took)


def buckets(events: Iterable[e.Event]) -> dict[datetime, Samples]:
    fold = TimesFold(None)
    for event in events:
        fold.follow(event)
    (samples,) = fold.kinds.values()
    return samples


def test_attempt_ending_with_period_counts_despite_rounding() -> None:
    day, begin = Day(), at('06:30')
    for event in attempts('a2', 'TASK_A', [(datetime.fromtimestamp(begin), 5.0)]):
        day.note(event.time + 4e-7, event)
    end_us = us_of(begin + 5.0)
    period = Period.all_planned('p', us_of(begin), end_us)
    (task,) = durations(Reading(day.records()), period, None).tasks
    assert task.count == 1
    (line,) = lines(durations(Reading(day.records()), period, None))
    assert line.endswith('; done 1 time')


def test_a_period_without_tasks_says_so() -> None:
    day = Day()
    day.note('06:00', e.OrchestratorStarted(cell='c', digest='d'))
    period = Period.all_planned('p', us_of(at('06:00')), us_of(at('07:00')))
    (line,) = lines(durations(Reading(day.records()), period, None))
    assert line == 'no task succeeded in this time: there are no durations'


def test_day_when_task_became_slower_is_found() -> None:
    drift = drift_of(buckets(of_days({MONDAY: 1.5, TUESDAY: 1.9}, noise=0.1)))
    assert drift is not None
    assert (drift.since, drift.word) == (TUESDAY, 'slower')
    assert drift.before_s == pytest.approx(1.5, abs=0.05)
    assert drift.after_s == pytest.approx(1.9, abs=0.05)


@pytest.mark.parametrize(
    'events',
    [
        of_days({MONDAY: 1.5}, noise=0.3),
        of_days({MONDAY: 1.5, TUESDAY: 1.52}, noise=0.001),
        of_days({MONDAY: 1.5, END: 1.9}, noise=0.1),
        of_days({MONDAY: 0.01, TUESDAY: 0.02}, noise=0.0),
    ],
    ids=['noise', 'too little', 'one level', 'the network'],
)
def test_what_is_no_lasting_change_is_none(events: list[e.Event]) -> None:
    assert drift_of(buckets(events)) is None


def test_failed_and_interrupted_attempts_do_not_count() -> None:
    started, ended = attempts('c', 'T', [(MONDAY, 600.0)])
    fold = TimesFold(None)
    restart = e.OrchestratorStarted(cell='c', digest='d', time=MONDAY.timestamp() + 300)
    for event in (*attempts('c', 'T', [(MONDAY, 9.0)], fails=True), started, restart, ended):
        fold.follow(event)
    assert not fold.kinds


def test_memory_stays_bounded_for_many_attempts() -> None:
    samples = Samples()
    for n in range(10_000):
        samples.add(float(n))
    assert samples.count == 10_000
    assert len(samples.seconds) <= MOST_KEPT
    assert samples.seconds[-1] > 9_000  # evenly over all of them


def test_durations_are_grouped_by_task_kind() -> None:
    fold = TimesFold(None)
    for event in attempts('c', 'T', [(MONDAY, 1.0), (MONDAY + timedelta(seconds=5), 2.0)]):
        fold.follow(event)
    assert list(fold.kinds) == [Kind('c', 'T')]


# --- the verb -----------------------------------------------------------------------------------


@pytest.fixture(scope='module')
def journal(tmp_path_factory: pytest.TempPathFactory) -> Path:
    events = of_days({MONDAY: 1.5, TUESDAY: 1.9}, noise=0.05)
    moves = [(MONDAY + timedelta(days=d, hours=9), 2.5) for d in range(12)]
    events += attempts('conveyor', 'MOVE_ONE_INDEX', moves)
    events.sort(key=lambda event: event.time)
    path = tmp_path_factory.mktemp('durations') / 'cell.sqlite3'
    with closing(SqliteStore(path)) as store:
        store.append([event.stamped(n, event.time) for n, event in enumerate(events, 1)])
    return path


@pytest.fixture
def words(journal: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    monkeypatch.setattr(bootstrap, 'installed_types', lambda: TYPES)
    return ['report', '--journal', str(journal)]


def test_the_verb_says_it_in_a_sentence(
    words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*words, '--durations', '--cell', str(REFERENCE_CELL)]) == 0
    printed = capsys.readouterr().out.splitlines()
    (slower,) = (line for line in printed if line.startswith('component_3b TASK_B: '))
    assert slower.startswith('component_3b TASK_B: 1.5 s nominal, 1.')
    assert 'in the last 7 days, slower since Tuesday, 2026-05-19 (1.5' in slower
    assert slower.endswith('; done 240 times')
    (steady,) = (line for line in printed if line.startswith('conveyor'))
    assert '25% slower than nominal all the time' in steady


def test_json_has_the_numbers(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*words, '--durations', '--json']) == 0
    tasks = {task['component']: task for task in json.loads(capsys.readouterr().out)}
    assert (tasks['conveyor']['nominal_s'], tasks['conveyor']['lately_s']) == (None, 2.5)
    assert tasks['component_3b']['drift']['since'].startswith('2026-05-19T00:00')


def test_diff_proposes_only_new_durations(
    words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cell = tmp_path / 'cell.yaml'
    before = REFERENCE_CELL.read_text()
    cell.write_text(before)
    assert main([*words, '--update-durations', '--cell', str(cell)]) == 0
    diff = capsys.readouterr().out
    assert cell.read_text() == before
    changes = [line for line in diff.splitlines() if line.startswith(('- ', '+ '))]
    removed, added = (edit[1:] for edit in changes[::2]), (edit[1:] for edit in changes[1::2])
    patched = before
    for old, new in zip(removed, added, strict=True):
        assert patched.count(old) == 1
        patched = patched.replace(old, new)
    cell.write_text(patched)
    after = parse_cell(patched, str(cell), TYPES)
    assert after.components['component_3b'].duration_s('TASK_B') == pytest.approx(1.9, abs=0.03)
    assert after.conveyor.component.default_duration_s == 2.5
    assert len(changes) == 4
    assert main([*words, '--update-durations', '--cell', str(cell)]) == 0
    assert 'there is nothing to change' in capsys.readouterr().out


def test_mistakes_are_sentences(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*words, '--update-durations']) == 2
    assert 'name it: --cell CELL' in capsys.readouterr().err
    assert main([*words, '--durations', '--csv']) == 2
    assert 'leave --csv out' in capsys.readouterr().err


# --- the text of a cell file --------------------------------------------------------------------


@pytest.mark.parametrize(
    ('before', 'after'),
    [
        ('a1: {durations: {T: 1.0}} # as bought', 'a1: {durations: {T: 1.9}} # as bought'),
        ('a1: {durations: {P: 1.0}}', 'a1: {durations: {T: 1.9, P: 1.0}}'),
        ('a1: {section: 1}', 'a1: {durations: {T: 1.9}, section: 1}'),
        ('a1: {durations: {}}', 'a1: {durations: {T: 1.9}}'),
        (
            'a1:\n    section: 1\n    durations:\n      T: 1  # slow\n      P: 2',
            'a1:\n    section: 1\n    durations:\n      T: 1.9  # slow\n      P: 2',
        ),
        (
            'a1:\n    durations:\n      # all of them\n      P: 2',
            'a1:\n    durations:\n      # all of them\n      T: 1.9\n      P: 2',
        ),
        (
            'a1:\n    # the first\n    section: 1',
            'a1:\n    # the first\n    durations: {T: 1.9}\n    section: 1',
        ),
    ],
)
def test_only_a_duration_changes_in_the_text(before: str, after: str) -> None:
    text = f'cell: c\ncomponents:\n  {before}\n  b1: {{durations: {{T: 1.0}}}}\n'
    expected = f'cell: c\ncomponents:\n  {after}\n  b1: {{durations: {{T: 1.0}}}}\n'
    assert with_durations(text, 'cell.yaml', {'a1': {'T': 1.9}}) == expected


def test_times_that_share_their_text_are_refused() -> None:
    text = 'components:\n  a1: {durations: &all {T: 1.0}}\n  b1: {durations: *all}\n'
    with pytest.raises(NotEditable, match=r'cell.yaml:2: what stands here is used more than once'):
        with_durations(text, 'cell.yaml', {'a1': {'T': 1.9}, 'b1': {'T': 1.2}})
