"""Semantics 6.10: generated scripts start when an engineer has released them."""

from __future__ import annotations

from dataclasses import replace

import pytest
from fakes.commands import ReleaseScript, RunNext
from fakes.line import THREE, Line, with_section
from fakes.operator import ann
from fakes.virtual_run import BY, VirtualRun

from bt_orchestrator.base.errors import CommandRefused
from bt_orchestrator.engine.asking.commands import prepared
from bt_orchestrator.model.by import By, Known, Role
from bt_orchestrator.model.cell import Release
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.jobs.isa95 import JobWord, job_word
from bt_orchestrator.model.jobs.job_commands import UpdateJob
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.requests import ask
from bt_orchestrator.model.script import Script
from bt_orchestrator.sim.simulation import Outcome, Simulation
from bt_orchestrator.store.memory import MemoryStore

LINE = Line()
MADE = 'made_from: {recipe: WM-100, version: 3}'


def made(text: str = THREE, name: str = 'made') -> Script:
    return LINE.script(f'{MADE}\n{text}', name)


GENERATED, OTHER = made(), made(THREE.replace('@a2', '@b2'))
WRITTEN = LINE.script(THREE, 'written')
WAITS = (
    f'its script was generated and is not released for this cell; release-script '
    f'{digest(GENERATED)} (by an engineer) lets it start in its turn'
)


@pytest.fixture
def run() -> VirtualRun:
    """Give an empty line."""
    return VirtualRun(LINE.cell, LINE.types)


def word(run: VirtualRun, job: str) -> JobWord:
    return job_word(run.state, run.job(job))


# --- waiting --------------------------------------------------------------------------------


def test_6_10_job_of_generated_script_awaits_release(run: VirtualRun) -> None:
    answer = run.add(('K', GENERATED))
    assert answer.message == f'K is queued; {WAITS}'
    run.go(50.0)
    assert word(run, 'K') is JobWord.NOT_ALLOWED_TO_START
    assert run.starts('place') == []
    assert 'Execute' not in run.states, 'there is nothing to do'
    answer = run.release(GENERATED)
    assert (
        answer.message == f'{digest(GENERATED)} is released for this cell; it was waited for by K'
    )
    run.go()
    assert run.counts('K')['packed'] == 1


def test_6_10_its_initialization_begins_when_it_is_released(run: VirtualRun) -> None:
    run.add(('K', made('initialization: [{id: first, @a1}]' + THREE, 'prepared')))
    run.go(50.0)
    assert run.starts('first') == []
    run.release(run.job('K').job.script)
    assert run.go().ended


def test_6_10_others_pass_it_and_it_keeps_its_place(run: VirtualRun) -> None:
    run.submit('J', WRITTEN, 3)
    run.add(('K', GENERATED), ('L', WRITTEN), ('M', GENERATED), ('N', WRITTEN))
    run.go(2.0)
    assert [word(run, name) for name in 'KLM'] == [
        JobWord.NOT_ALLOWED_TO_START,
        JobWord.ALLOWED_TO_START,
        JobWord.NOT_ALLOWED_TO_START,
    ]
    run.control('hold', 'N')
    run.go(13.0)
    assert run.order('job.started', 'job') == ['J', 'L']
    run.release(GENERATED)
    run.control('release', 'N')
    assert run.go().order('job.started', 'job') == ['J', 'L', 'K', 'M', 'N']


def test_6_10_handwritten_script_needs_no_release(run: VirtualRun) -> None:
    assert run.add(('K', WRITTEN)).message == 'K is queued'
    assert run.go().ended


def test_6_10_with_release_automatic_none_does() -> None:
    run = VirtualRun(replace(LINE.cell, release=Release.AUTOMATIC), LINE.types)
    assert run.add(('K', GENERATED)).message == 'K is queued'
    assert run.go().ended


def test_6_10_default_release_keeps_cell_digest() -> None:
    assert digest(LINE.cell) == digest(replace(LINE.cell, release=Release.ENGINEER))
    assert digest(LINE.cell) != digest(replace(LINE.cell, release=Release.AUTOMATIC))


# --- what a release is for ------------------------------------------------------------------


def test_6_10_release_may_precede_queued_job(run: VirtualRun) -> None:
    assert run.release(GENERATED).message == f'{digest(GENERATED)} is released for this cell'
    assert run.add(('K', GENERATED)).message == 'K is queued'
    assert run.go().ended


def test_6_10_other_script_of_same_name_needs_release(run: VirtualRun) -> None:
    run.add(('K', GENERATED), ('L', OTHER))
    run.release(OTHER)
    run.go(50.0)
    assert run.order('job.completed', 'job') == ['L']
    assert word(run, 'K') is JobWord.NOT_ALLOWED_TO_START


def test_6_10_one_for_another_cell_file_is_refused(run: VirtualRun) -> None:
    run.add(('K', GENERATED))
    answer = run.ask(ReleaseScript(digest(GENERATED), ann(), '0123456789ab'))
    assert not answer.accepted
    assert 'was generated for another cell file (0123456789ab)' in answer.message
    assert run.records[-1]['event'] == 'operator.refused'
    assert run.records[-1]['digest'] == digest(GENERATED)
    assert run.ask(ReleaseScript(digest(GENERATED), ann(), digest(LINE.cell))).accepted


def test_6_10_a_second_release_is_refused(run: VirtualRun) -> None:
    run.release(GENERATED)
    answer = run.release(GENERATED)
    assert not answer.accepted
    assert answer.message == f'{digest(GENERATED)} is released for this cell already'


def test_6_10_release_record_names_user_reason_and_cell(run: VirtualRun) -> None:
    run.release(GENERATED)
    decided, released = run.records[-2:]
    assert (decided['event'], decided['answer']) == ('operator.decided', 'release_script')
    assert (decided['who'], decided['digest']) == ('Eve', digest(GENERATED))
    assert released['event'] == 'script.released'
    assert (released['digest'], released['cell_digest']) == (
        digest(GENERATED),
        digest(LINE.cell),
    )
    assert released['reason'].startswith('Eve')


def test_6_10_only_an_engineer_may(run: VirtualRun) -> None:
    run.add(('K', GENERATED))
    operator = By('Ann', 'a test', 'now', Role.OPERATE, Known.LOCAL_USER)
    answer = run.ask(ReleaseScript(digest(GENERATED), operator))
    assert not answer.accepted
    assert 'engineer' in answer.message


# --- beside other reasons to wait -----------------------------------------------------------


def test_6_10_job_release_and_next_do_not_release_script(run: VirtualRun) -> None:
    run.add(('K', GENERATED))
    answer = run.control('release', 'K')
    assert not answer.accepted
    assert answer.message == f'K is not released: {WAITS}'
    answer = run.ask(RunNext('K', BY))
    assert answer.accepted
    assert WAITS in answer.message
    assert not run.go(50.0).job('K').started


def test_6_10_it_may_be_held_and_released_besides(run: VirtualRun) -> None:
    run.add(('K', GENERATED))
    assert run.control('hold', 'K').accepted
    run.release(GENERATED)
    assert not run.go(50.0).job('K').started, 'a person holds it'
    assert run.control('release', 'K').accepted
    assert run.go().ended


def test_6_10_it_may_lack_a_component_besides(run: VirtualRun) -> None:
    run.service('a2', out=True)
    run.add(('K', GENERATED))
    both = run.control('release', 'K').message
    assert 'K is not released: ' in both
    assert 'K is unavailable: ' in both
    run.release(GENERATED)
    assert not run.go(50.0).job('K').started
    run.service('a2', out=False)
    assert run.go().ended


def test_6_10_a_job_with_another_script_is_asked_anew(run: VirtualRun) -> None:
    run.add(('K', GENERATED))
    run.add(('L', WRITTEN), held=True)
    answer = run.ask(UpdateJob(Job('L', GENERATED, 1, {}), BY))
    assert answer.message == f'L is updated\n{WAITS}'
    assert run.ask(UpdateJob(Job('K', WRITTEN, 1, {}), BY)).message == 'K is updated'
    run.go(50.0)
    assert run.order('job.completed', 'job') == ['K']
    assert run.job('L').awaits_release


def test_6_10_a_job_with_another_quantity_waits_as_before(run: VirtualRun) -> None:
    run.add(('K', GENERATED))
    assert WAITS in run.ask(UpdateJob(Job('K', GENERATED, 2, {}), BY)).message
    assert run.job('K').awaits_release


def test_6_10_one_that_is_aborted_in_the_queue_ends(run: VirtualRun) -> None:
    run.add(('K', made('initialization: [{id: first, @b3}]' + THREE)))
    assert run.control('abort', 'K').accepted
    assert run.go(1.0).ended


# --- as a request ---------------------------------------------------------------------------


def digest_asked(run: VirtualRun, script: str) -> str:
    asked = ask('script.release_script', ann(), script=script)
    script_asked: str = prepared(asked, run.state, LINE.types)['script']
    return script_asked


def test_6_10_release_may_name_awaited_script(run: VirtualRun) -> None:
    run.add(('K', GENERATED), ('L', WRITTEN))
    assert digest_asked(run, 'made') == digest(GENERATED)
    assert digest_asked(run, 'aaaabbbbcccc') == 'aaaabbbbcccc'
    with pytest.raises(CommandRefused, match="no job in the queue waits for 'written'; name the"):
        digest_asked(run, 'written')
    run.add(('M', OTHER))
    with pytest.raises(CommandRefused, match="several scripts are called 'made'"):
        digest_asked(run, 'made')


def test_6_10_simulation_runs_without_release() -> None:
    simulation = Simulation(LINE.cell, LINE.types, MemoryStore())
    assert [reply.accepted for reply in simulation.submit([Job('K', GENERATED, 1, {})])] == [True]
    assert simulation.run() is Outcome.FINISHED
    simulation.close()


def test_6_10_what_is_likely_needs_no_release(run: VirtualRun) -> None:
    section = with_section(2, '[{id: work, @a2, on_failure: reject, likely: 0.1}]')
    text = section.replace('qty_change: -1', 'qty_change: -1, runs_for: all')
    run.release(made(text))
    assert run.add(('K', made(text.replace('0.1', '0.2')))).message == 'K is queued'
    assert run.go().counts('K')['packed'] == 1
