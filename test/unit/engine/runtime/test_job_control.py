"""Every state of a job and everything that can be asked of it: what the table says happens."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import pytest
from fakes.commands import Pause
from fakes.line import THREE, Line
from fakes.operator import ann
from fakes.virtual_run import BY, VirtualRun

from bt_orchestrator.engine.runtime.job_queue import CONTROLS
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.jobs.isa95 import JobWord, job_word
from bt_orchestrator.model.jobs.job_commands import UpdateJob
from bt_orchestrator.model.jobs.job_control import (
    ABORT,
    ANOTHER,
    CANCEL,
    CLEAR,
    METHODS,
    PAUSE,
    RESUME,
    REVOKE_START,
    START,
    STOP,
    STORE,
    STORE_AND_START,
    UPDATE,
    Method,
)
from bt_orchestrator.model.jobs.order import Job

LINE = Line()
TEXT = THREE.replace('qty_change: -1', 'qty_change: -1, runs_for: all')
SCRIPT = LINE.script(TEXT)


def _queued() -> VirtualRun:
    """Give a job that waits behind another one."""
    run = LINE.begin(quantity=9)
    run.submit('K', SCRIPT, 2)
    return run


def _held() -> VirtualRun:
    run = _queued()
    assert run.control('hold', 'K').accepted
    return run


def _running() -> VirtualRun:
    run = VirtualRun(LINE.cell, LINE.types)
    run.submit('K', SCRIPT, 3)
    return run.go(until=4.0)


def _interrupted() -> VirtualRun:
    line = Line(faults={'a2': '#1=abort'})
    run = VirtualRun(line.cell, line.types)
    run.submit('K', SCRIPT, 3)
    return run.go(until=6.0)


def _suspended() -> VirtualRun:
    run = _running()
    assert run.control('pause', 'K').accepted
    return run


def _ended() -> VirtualRun:
    return _running().go()


def _aborted() -> VirtualRun:
    run = _running()
    assert run.control('abort', 'K').accepted
    return run.go()


def _absent() -> VirtualRun:
    return VirtualRun(LINE.cell, LINE.types).go()


STATES: Mapping[JobWord | None, Callable[[], VirtualRun]] = {
    None: _absent,
    JobWord.NOT_ALLOWED_TO_START: _held,
    JobWord.ALLOWED_TO_START: _queued,
    JobWord.RUNNING: _running,
    JobWord.HELD: _interrupted,
    JobWord.SUSPENDED: _suspended,
    JobWord.ENDED: _ended,
    JobWord.ABORTED: _aborted,
}
"""How a job K comes into each state."""

ASK: Mapping[str, Callable[[VirtualRun], Answer]] = {
    STORE.name: lambda run: run.add(('K', SCRIPT), held=True),
    STORE_AND_START.name: lambda run: run.add(('K', SCRIPT)),
    UPDATE.name: lambda run: run.ask(UpdateJob(Job('K', SCRIPT, 7, {}), BY)),
    START.name: lambda run: run.control('release', 'K'),
    REVOKE_START.name: lambda run: run.control('hold', 'K'),
    PAUSE.name: lambda run: run.control('pause', 'K'),
    RESUME.name: lambda run: run.control('resume', 'K'),
    STOP.name: lambda run: run.control('stop', 'K'),
    ABORT.name: lambda run: run.control('abort', 'K'),
    CANCEL.name: lambda run: run.control('cancel', 'K'),
    CLEAR.name: lambda run: run.control('clear', 'K'),
}


def word(run: VirtualRun) -> JobWord | None:
    """Return the state of the job K; None: it is not listed."""
    job = run.state.jobs.get('K') or run.state.ended.get('K')
    return None if job is None else job_word(run.state, job)


@pytest.mark.parametrize('method', METHODS, ids=lambda method: str(method.name))
@pytest.mark.parametrize('before', STATES, ids=str)
def test_every_method_in_every_state(before: JobWord | None, method: Method) -> None:
    run = STATES[before]()
    assert word(run) is before
    recorded = len(run.records)
    answer = ASK[method.name](run)
    assert answer.accepted is (before in method.changes), answer.message
    if not answer.accepted:
        _check_refusal(run, recorded, answer, before, method)
        return
    _check_recorded(run, recorded, 'operator.decided')
    after = method.changes[before]
    if method in (STOP, ABORT) and before not in (
        JobWord.ALLOWED_TO_START,
        JobWord.NOT_ALLOWED_TO_START,
    ):
        _let_it_drain(run)
    if before is None and method is STORE_AND_START:
        after = JobWord.RUNNING  # nothing is in front of it
    assert word(run) is after


def _check_refusal(
    run: VirtualRun, recorded: int, answer: Answer, before: JobWord | None, method: Method
) -> None:
    _check_recorded(run, recorded, 'operator.refused')
    assert len(run.records) == recorded + 1
    assert word(run) is before
    if method in (STORE, STORE_AND_START):
        assert answer.message == 'order K was given before; choose another id'
    elif before is None:
        assert answer.message == 'there is no job K; jobs now: none'
    else:
        assert answer.message.startswith(f'K is {before.value}; {method.title} is for jobs that')


def _check_recorded(run: VirtualRun, recorded: int, event: str) -> None:
    """Who commanded it, from where and why stands first."""
    record = run.records[recorded]
    assert record['event'] == event
    about = {'job': 'K', 'who': 'Ann', 'origin': 'the test', 'reason': 'it was time'}
    assert about.items() <= record.items()


def _let_it_drain(run: VirtualRun) -> None:
    run.go()
    for hold in list(run.state.holds.values()):
        assert run.answer('retry' if 'retry' in hold.answers else 'skip', hold.id).accepted
    run.go()


def test_every_command_word_maps_to_its_method() -> None:
    verbs = {verb: method for verb, (method, _, _) in CONTROLS.items()}
    of_words = {m for m in METHODS if m not in (STORE, STORE_AND_START, UPDATE)} | {ANOTHER}
    assert verbs == {m.verb: m for m in of_words}


def test_alias_is_recorded_as_table_word() -> None:
    run = _queued()
    assert run.control('remove', 'K').accepted
    assert run.all('operator.decided')[-1]['answer'] == 'cancel'


@pytest.mark.parametrize('verb', CONTROLS)
def test_ending_job_accepts_only_abort(verb: str) -> None:
    run = _running()
    assert run.control('stop', 'K').accepted
    answer = run.control(verb, 'K')
    assert answer.accepted is (verb == 'abort'), answer.message
    assert not run.control('abort', 'K').accepted or verb != 'abort'
    if verb in ('pause', 'stop'):
        what = 'K is stopping already and ends when its last item has left the line'
        assert answer.message == f'{what}; only Abort is left'


def test_job_paused_with_cell_resumes_with_cell() -> None:
    run = _running()
    run.ask(Pause(ann('lunch')))
    assert word(run) is JobWord.SUSPENDED
    answer = run.control('resume', 'K')
    assert answer.message == 'K is not paused, the whole cell is; resume the cell instead'
