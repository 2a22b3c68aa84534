"""Semantics 7.5: components that are out of service."""

from __future__ import annotations

import pytest
from fakes.commands import RunNext, SetService, Stop
from fakes.line import THREE, Line
from fakes.operator import ann
from fakes.virtual_run import BY, VirtualRun

from bt_orchestrator.model.jobs.isa95 import JobWord, job_word
from bt_orchestrator.model.jobs.job_commands import UpdateJob
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.wait import WaitKind
from bt_orchestrator.sim.simulation import Simulation

LINE = Line()
SCRIPT = LINE.script(THREE)
OTHER = LINE.script(THREE.replace('@a2', '@b2'), 'other')
PREPARED = LINE.script('initialization: [{id: first, @b3}]' + THREE, 'prepared')


def line(line: Line = LINE, quantity: int = 3, script: str = THREE) -> VirtualRun:
    """Give a line on which J runs."""
    run = VirtualRun(line.cell, line.types)
    run.submit('J', line.script(script), quantity)
    return run


def word(run: VirtualRun, job: str) -> JobWord:
    return job_word(run.state, run.job(job))


# --- the component --------------------------------------------------------------------------


def test_7_5_component_out_of_service_gets_no_goal() -> None:
    run = line().go(2.0)
    assert run.service('a2', out=True).accepted
    run.go(100.0)
    assert run.starts('work') == []
    assert run.service('a2', out=False).accepted
    run.go()
    assert run.ended
    assert run.counts()['packed'] == 3


def test_7_5_running_task_continues_and_answer_names_it() -> None:
    run = line().go(3.5)
    answer = run.service('a2', out=True)
    assert 'work of J/1 runs there and goes on to its end' in answer.message
    run.go(100.0)
    assert run.times('task.succeeded', task='work') == [4.0]
    assert len(run.starts('work')) == 1


def test_7_5_neither_retries_nor_an_operators_retry_start() -> None:
    faulty = Line(faults={'a2': '#1=abort #2=abort'})
    run = line(faulty, script=THREE.replace('@a2', '@a2, retries: 1, retry_delay: 5')).go(5.0)
    run.service('a2', out=True)
    run.go(60.0)
    assert len(run.starts('work')) == 1
    run.service('a2', out=False)
    run.go(100.0)
    assert len(run.starts('work')) == 2
    run.service('a2', out=True)
    assert run.answer('retry').accepted
    run.go(200.0)
    assert len(run.starts('work')) == 2
    assert run.state.reserved['a2'].task == 'work'
    run.service('a2', out=False)
    assert run.go().ended


def test_7_5_initialization_waits_too() -> None:
    run = VirtualRun(LINE.cell, LINE.types)
    run.submit('J', LINE.script('initialization: [{id: i, @lamp}, {id: k, @b3}]' + THREE, 'i'))
    run.go(0.5)
    assert run.job().started
    run.service('b3', out=True)
    run.submit('K', PREPARED)
    run.go(100.0)
    assert run.starts('first') == []


def test_7_5_status_says_why_in_words_and_as_data() -> None:
    run = line().go(2.0)
    run.service('a2', out=True)
    run.go(100.0)
    words = 'waiting for a2, which is out of service (Ann: worn)'
    assert run.waits()['section 2'] == words
    status = run.sim.status()
    (section,) = [part for part in status.sections if part.number == 2]
    assert {(wait.kind, wait.name) for wait in section.waits} == {(WaitKind.OUT_OF_SERVICE, 'a2')}
    (component,) = [part for part in status.components if part.name == 'a2']
    assert not component.ready
    assert component.out_of_service == 'Ann: worn'
    assert component.out_of_service_since == 1.0
    (job,) = status.jobs
    assert job.unavailable == ('a2',)


def test_7_5_it_is_recorded_with_who_and_why() -> None:
    run = line().go(2.0)
    run.service('a2', out=True)
    decided, out = run.records[-2:]
    assert (decided['event'], decided['answer'], decided['component']) == (
        'operator.decided',
        'out_of_service',
        'a2',
    )
    assert (decided['who'], decided['reason']) == ('Ann', 'worn')
    assert (out['event'], out['component']) == ('component.out_of_service', 'a2')


@pytest.mark.parametrize(
    ('component', 'out', 'why'),
    [
        ('a2', False, 'a2 is in service; out of service now: b2'),
        ('b2', True, 'b2 is out of service already (Ann: worn)'),
        ('a9', True, 'there is no component a9; the cell has conveyor'),
    ],
)
def test_7_5_what_would_change_nothing_is_refused(component: str, *, out: bool, why: str) -> None:
    run = line()
    run.service('b2', out=True)
    answer = run.service(component, out=out)
    assert not answer.accepted
    assert why in answer.message
    assert run.records[-1]['event'] == 'operator.refused'
    assert run.records[-1]['component'] == component


def test_7_5_a_stop_does_not_wait_for_it() -> None:
    run = line().go(2.0)
    run.service('a2', out=True)
    run.go(50.0)
    assert run.command(Stop).accepted
    run.go(100.0)
    assert run.states[-1] == 'Stopped'


def test_7_5_outage_neither_starves_nor_blocks_line() -> None:
    run = line()
    run.go(1.5)
    run.service('a3', out=True)
    run.go(100.0)
    assert 'Suspended' not in run.states
    assert run.state.stop_reason is None


# --- the belt -------------------------------------------------------------------------------


def test_7_5_conveyor_outage_stops_belt_not_cycles() -> None:
    run = line().go(3.5)
    run.service('conveyor', out=True)
    run.submit('K', OTHER)
    run.go(100.0)
    assert run.times('task.succeeded', task='work') == [4.0]
    assert len(run.times('belt.indexed')) == 1
    assert not run.state.indexing
    assert 'waiting for conveyor, which is out of service' in run.waits()['belt']
    assert word(run, 'K') is JobWord.NOT_ALLOWED_TO_START
    run.service('conveyor', out=False)
    assert run.go().ended


def test_7_5_a_move_that_runs_goes_on() -> None:
    run = line().go(2.0)
    answer = run.service('conveyor', out=True)
    assert 'index runs there' in answer.message
    run.go(100.0)
    assert run.times('belt.indexed') == [3.0]


# --- the queue ------------------------------------------------------------------------------


def test_7_5_jobs_needing_component_are_passed_until_return() -> None:
    run = line()
    run.add(('K', SCRIPT), ('L', OTHER), ('M', SCRIPT))
    run.go(2.0)
    answer = run.service('a2', out=True)
    assert 'passed in the queue, because they need it: K, M' in answer.message
    assert [word(run, name) for name in 'KLM'] == [
        JobWord.NOT_ALLOWED_TO_START,
        JobWord.ALLOWED_TO_START,
        JobWord.NOT_ALLOWED_TO_START,
    ]
    run.control('stop', 'J')
    run.service('b1', out=True)
    run.service('a2', out=False)
    run.go()
    assert run.order('job.started', 'job') == ['J', 'K', 'L', 'M']


def test_7_5_line_begins_next_job_lacking_nothing() -> None:
    run = VirtualRun(LINE.cell, LINE.types)
    run.service('a2', out=True)
    run.add(('K', SCRIPT), ('L', OTHER))
    run.go(50.0)
    assert run.order('job.completed', 'job') == ['L']
    run.service('a2', out=False)
    run.go()
    assert run.order('job.completed', 'job') == ['L', 'K']


def test_7_5_initialization_alone_makes_a_job_need_it() -> None:
    run = VirtualRun(LINE.cell, LINE.types)
    run.service('b3', out=True)
    (answer,) = [run.add(('K', PREPARED))]
    assert answer.message == (
        'K is queued; it needs b3, which is out of service; in-service lets it start in its turn'
    )
    assert run.job('K').unavailable == ('b3',)


def test_7_5_release_and_next_cannot_lift_it() -> None:
    run = VirtualRun(LINE.cell, LINE.types)
    run.service('a2', out=True)
    run.add(('K', SCRIPT))
    answer = run.control('release', 'K')
    assert not answer.accepted
    assert answer.message == (
        'K is unavailable: it needs a2, which is out of service; in-service lets it start in its '
        'turn'
    )
    answer = run.ask(RunNext('K', BY))
    assert answer.accepted
    assert 'it needs a2' in answer.message
    assert not run.go(50.0).job('K').started


def test_7_5_a_job_may_be_held_and_released_meanwhile() -> None:
    run = VirtualRun(LINE.cell, LINE.types)
    run.service('a2', out=True)
    run.add(('K', SCRIPT))
    assert run.control('hold', 'K').accepted
    assert not run.control('hold', 'K').accepted
    run.service('a2', out=False)
    assert not run.go(50.0).job('K').started, 'a person holds it'
    run.service('a2', out=True)
    assert 'it needs a2' in run.control('release', 'K').message
    assert not run.go(100.0).job('K').started
    run.service('a2', out=False)
    assert run.go().ended


def test_7_5_of_two_components_both_must_be_in_service() -> None:
    run = VirtualRun(LINE.cell, LINE.types)
    run.service('a2', out=True)
    run.add(('K', SCRIPT))
    run.service('a3', out=True)
    run.service('a2', out=False)
    assert run.job('K').unavailable == ('a3',)
    assert not run.go(50.0).job('K').started
    run.service('a3', out=False)
    assert run.go().ended


def test_7_5_changed_job_may_no_longer_need_component() -> None:
    run = VirtualRun(LINE.cell, LINE.types)
    run.service('a2', out=True)
    run.add(('K', SCRIPT))
    assert run.ask(UpdateJob(Job('K', OTHER, 1, {}), BY)).accepted
    assert run.go(50.0).ended


def test_7_5_an_aborted_job_of_the_queue_ends() -> None:
    run = VirtualRun(LINE.cell, LINE.types)
    run.service('b3', out=True)
    run.add(('K', PREPARED))
    assert run.control('abort', 'K').accepted
    assert run.go(1.0).ended


def test_7_5_answer_advises_on_job_on_line() -> None:
    run = line().go(2.0)
    answer = run.service('a2', out=True)
    assert (
        'J on the line needs a2 and waits; to make the rest otherwise, stop it (job stop J) and '
        'queue the rest anew'
    ) in answer.message
    done = line(quantity=1).go(4.5)
    assert 'on the line' not in done.service('a2', out=True).message, 'it has done that already'


def test_7_5_cell_with_unavailable_jobs_starts_on_return() -> None:
    run = VirtualRun(LINE.cell, LINE.types)
    run.service('a2', out=True)
    run.add(('K', SCRIPT))
    assert run.go(50.0).states == []
    run.service('a2', out=False)
    assert run.go().ended


def test_7_5_simulation_job_without_sender_stays_unavailable() -> None:
    sim = Simulation(LINE.cell, LINE.types, VirtualRun(LINE.cell, LINE.types).store)
    assert sim.orchestrator.ask(SetService('a2', False, ann('worn'))).accepted
    sim.submit([Job('K', SCRIPT, 1)])
    assert sim.state.jobs['K'].unavailable == ('a2',)
    sim.close()
