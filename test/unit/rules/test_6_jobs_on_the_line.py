"""Semantics 6.6: what operators do with the jobs on the line, and the line that runs empty."""

from __future__ import annotations

import pytest
from fakes.commands import Abort, Clear, Pause, Reset, Start, Stop, StopAfter
from fakes.line import THREE, Line
from fakes.queued_jobs import LINE, SCRIPT, begun, queue, queued
from fakes.virtual_run import BY, VirtualRun

from bt_orchestrator.model.judging.belt_statement import AsShown
from bt_orchestrator.model.packml import PackmlState

TOLERANT = LINE.script(THREE.replace('qty_change: -1', 'qty_change: -1, runs_for: all'))
"""Packs rejected items too."""


# --- jobs on the line -----------------------------------------------------------------------


def test_6_6_paused_job_begins_nothing_and_keeps_line() -> None:
    run = queued('K')
    run.go(until=1.5)
    assert run.control('pause', 'J').message == 'J begins no more items'
    run.go(until=60.0)
    assert run.counts()['packed'] == run.counts()['started'] == 2  # one was begun ahead
    assert run.waits()['section 1'] == 'waiting for J to be resumed'
    assert begun(run) == ['J']
    run.control('resume', 'J')
    run.go()
    assert run.counts()['packed'] == 3
    assert run.ended


def test_6_6_stopped_job_ends_with_begun_items() -> None:
    run = queued('K')
    run.go(until=1.5)
    assert run.control('stop', 'J').accepted
    run.go()
    (end,) = run.all('job.completed', job='J')
    assert end['exit_status'] == 'stopped'
    assert end['reason'] == 'Ann decided stop: it was time'
    assert (end['counts']['started'], end['counts']['packed']) == (2, 2)
    assert begun(run) == ['J', 'K']
    assert run.ended


def test_6_6_job_stopped_before_first_item_stops_preparation() -> None:
    text = 'initialization: [{id: warm, @b1}, {id: light, @b3}]\n'
    text += 'initialization_dependencies: [{upstream: warm, downstream: light}]\n'
    run = LINE.begin(text + THREE)
    run.control('stop', 'J')
    run.go()
    assert run.ended
    assert run.order('task.skipped', 'reason') == ['job stopped']


def test_6_6_a_stopped_job_prepares_what_its_items_need() -> None:
    text = 'initialization: [{id: warm, @b3}, {id: light, @b3.TASK_B}]\n'
    text += 'initialization_dependencies: [{upstream: warm, downstream: light}]\n'
    run = Line(seconds={'b3': 20.0}).begin(text + THREE, 3)
    run.go(until=1.5)
    run.control('stop', 'J')
    run.go()
    assert run.all('task.skipped') == []
    assert run.starts('light') == [20.0]
    assert run.starts('pack')[0] == 40.0
    assert run.ended


def test_6_6_stopped_job_skips_rest_after_last_item() -> None:
    """No list needs section 4's device; its second task waits for the first, which is slow."""
    text = 'initialization: [{id: slow, @b4}, {id: idle, @b4.TASK_B}]\n'
    text += 'initialization_dependencies: [{upstream: slow, downstream: idle}]\n'
    line = Line(4, seconds={'b4': 20.0})
    run = line.begin(text + THREE, 3)
    run.go(until=1.5)
    run.control('stop', 'J')
    run.go(until=9.5)
    assert run.all('task.skipped') == []
    run.go()
    (skipped,) = run.all('task.skipped')
    assert (skipped['task'], skipped['reason']) == ('idle', 'job stopped')
    assert run.times('task.skipped') == run.times('item.removed')[-1:] == [10.0]
    assert run.times('job.completed') == [20.0]
    assert run.ended


def test_6_6_a_queued_job_is_aborted_at_once() -> None:
    run = queued('KL')
    assert run.control('abort', 'K').accepted
    assert run.times('job.aborted', job='K') == [0.0]
    assert run.state.ended['K'].progress.started == 0
    run.go()
    assert begun(run) == ['J', 'L']


def test_6_6_held_job_with_preparation_aborts_at_once() -> None:
    prepared = LINE.script(f'initialization: [{{id: ready, @lamp}}]{THREE}', 'prepared')
    run = queued('')
    run.add(('K', prepared), held=True)
    run.control('abort', 'K')
    assert run.times('job.aborted', job='K') == [0.0]
    run.go()
    assert run.ended


PREPARED = LINE.script(f'initialization: [{{id: ready, @lamp}}]{THREE}', 'prepared')


@pytest.mark.parametrize('how', ['pause', 'stop', 'abort'])
@pytest.mark.parametrize('held', [False, True])
def test_6_6_queued_job_aborts_at_once_in_any_state(how: str, held: bool) -> None:
    run = queued('')
    run.add(('K', PREPARED), held=held)
    run.go(until=0.5)
    assert run.command({'pause': Pause, 'stop': Stop, 'abort': Abort}[how]).accepted
    run.go(until=10.0)
    assert run.control('abort', 'K').accepted
    assert run.job('K').ended_at == run.now
    assert 'K' not in begun(run)


def test_6_6_queued_job_aborts_at_once_during_hold() -> None:
    line = Line(faults={'lamp': '#1=abort'})
    script = line.script(f'initialization: [{{id: ready, @lamp}}]{THREE}', 'prepared')
    run = VirtualRun(line.cell, line.types)
    run.add(('J', script), ('K', script))
    run.go()
    assert run.state.packml is PackmlState.HELD
    assert run.control('abort', 'K').accepted
    assert run.job('K').ended_at == run.now


def test_6_6_queued_job_is_cancelled_in_any_state() -> None:
    run = queued('')
    run.add(('K', PREPARED))
    run.command(Pause)
    assert run.control('stop', 'K').message == (
        'K is AllowedToStart; Stop is for jobs that are Running or Interrupted/Held or '
        'Interrupted/Suspended'
    )
    assert run.control('cancel', 'K').accepted
    assert queue(run) == ''


@pytest.mark.parametrize('verb', ['stop', 'abort'])
def test_6_6_job_without_items_ends_during_pause(verb: str) -> None:
    """Only initialization is left of J: one task that runs, and one that waits for it."""
    line = Line(seconds={'a1': 5.0})
    run = line.begin(
        'initialization: [{id: one, @a1.PREPARE}, {id: two, @a2.PREPARE}]\n'
        f'initialization_dependencies: [{{upstream: one, downstream: two}}]{THREE}'
    )
    run.go(until=1.0)
    run.command(Pause)
    assert run.control(verb, 'J').accepted
    run.go()
    assert run.ended
    assert run.starts('two') == []
    assert [record['task'] for record in run.all('task.skipped')] == ['two']


def test_6_6_an_aborted_job_drains_and_the_next_follows() -> None:
    run = queued('K', TOLERANT)
    run.go(until=4.5)
    run.control('abort', 'J')
    run.go()
    (end,) = run.all('job.aborted', job='J')
    assert end['counts']['rejected'] == 2
    assert run.ended


def test_6_6_the_end_of_a_job_carries_its_counts() -> None:
    run = queued('')
    run.go()
    (end,) = run.all('job.completed')
    assert end['exit_status'] == 'completed'
    assert end['counts'] == {
        'started': 3,
        'placed': 3,
        'processed': 3,
        'packed': 3,
        'rejected': 0,
        'nonconforming': 0,
        'missing': 0,
        'removed': 0,
    }


def test_6_6_a_cleared_job_is_listed_no_more() -> None:
    run = queued('')
    run.go()
    assert run.control('clear', 'J').accepted
    assert run.state.ended == {}
    message = run.control('clear', 'J').message
    assert message == 'J is no longer listed; the journal has its history'


# --- the line runs empty --------------------------------------------------------------------


def test_6_6_the_cell_stops_after_the_current_item() -> None:
    run = queued('K')
    run.go(until=1.5)
    assert run.ask(StopAfter('item', BY)).message == 'the cell stops after the current item'
    assert run.state.stop_after == 'item'
    run.go(until=60.0)
    assert run.state.packml is PackmlState.STOPPED
    assert len(run.all('queue.stop_reached')) == 1
    assert (run.counts()['started'], run.counts()['packed']) == (2, 2)
    assert begun(run) == ['J']


def test_6_6_the_cell_stops_after_the_current_job() -> None:
    run = queued('KL')
    run.ask(StopAfter('job', BY))
    run.go(until=60.0)
    assert run.state.packml is PackmlState.STOPPED
    assert begun(run) == list(run.state.ended) == ['J']
    reasons = [r.get('reason') for r in run.all('cell.state_changed', state='Stopping')]
    assert reasons == ['stop after the current job']


@pytest.mark.parametrize('after', ['item', 'job'])
def test_6_6_cell_stops_after_last_queued_job(after: str) -> None:
    run = LINE.begin()
    run.go(until=1.5)
    run.ask(StopAfter(after, BY))
    run.go()
    assert run.ended
    assert run.state.packml is PackmlState.STOPPED
    assert run.order('queue.stop_reached', 'after') == [after]
    assert_works_again(run)


def assert_works_again(run: VirtualRun) -> None:
    """Start the cell and see that the next order is made, and that the cell is Complete then."""
    assert run.state.stop_after is None
    run.add(('L', SCRIPT))
    for command in (Reset, Start):
        assert run.command(command).accepted
    run.go()
    assert run.ended
    assert run.go().state.packml is PackmlState.COMPLETE


def test_6_6_start_does_not_revoke_pending_stop() -> None:
    run = queued('K')
    run.go(until=1.5)
    run.ask(StopAfter('job', BY))
    for command in (Stop, Reset, Start):
        run.command(command)
        run.go(until=run.now + 10.0)
    run.go(until=run.now + 60.0)
    assert run.state.packml is PackmlState.STOPPED
    assert begun(run) == list(run.state.ended) == ['J']


TWO_STEPS = """
initialization: [{id: second, @a2}, {id: first, @b1}]
initialization_dependencies: [{upstream: first, downstream: second}]
""" + THREE.lstrip()


@pytest.mark.parametrize('after', ['item', 'job'])
def test_6_6_pending_stop_is_reached_in_stopped_cell(after: str) -> None:
    """The job ends while the cell is Stopped."""
    run = Line().begin(TWO_STEPS).go(until=0.5)
    run.ask(StopAfter(after, BY))
    run.command(Stop)
    run.go(until=5.0)
    run.control('abort', 'J')
    assert (run.ended, run.state.packml) == (True, PackmlState.STOPPED)
    assert run.order('queue.stop_reached', 'after') == [after]
    assert_works_again(run)


@pytest.mark.parametrize('is_aborted', [False, True])
def test_6_6_line_is_empty_after_last_item_leaves(is_aborted: bool) -> None:
    """Also where its section has more to do then, which a cell that stands does not begin."""
    run = LINE.begin(THREE.replace('-1}', '-1}, {id: clean, @b3}'), 1)
    run.go(until=6.5)
    assert run.starts('pack') == [6.0]
    run.ask(StopAfter('item', BY))
    run.command(Abort if is_aborted else Stop)
    run.go(until=60.0)
    if is_aborted:
        run.answer('mark_done')
        run.command(Clear, belt=AsShown(run.state.seq))
    assert run.state.packml is PackmlState.STOPPED
    assert run.order('queue.stop_reached', 'after') == ['item']
    run.add(('K', SCRIPT))
    for command in (Reset, Start):
        assert run.command(command).accepted
    run.go()
    assert len(run.starts('clean')) == 1
    assert begun(run) == ['J', 'K']
    assert run.ended


@pytest.mark.parametrize(('task', 'component'), [('first', 'b1'), ('second', 'a2')])
def test_6_6_empty_line_with_hold_awaits_answer(task: str, component: str) -> None:
    run = Line(faults={component: '#1=abort'}).begin(TWO_STEPS).go(until=0.5)
    run.ask(StopAfter('item', BY))
    run.go()
    assert [hold.task for hold in run.state.holds.values()] == [task]
    assert run.state.packml.value == 'Held'
    run.answer('mark_done')
    run.go()
    assert run.state.packml is PackmlState.STOPPED
    assert not run.state.holds
    assert len(run.all('queue.stop_reached')) == 1


def test_6_6_cell_finishes_current_preparation_before_stop() -> None:
    """Also where the next task of it starts a moment after the one before has ended."""
    run = Line(faults={'a2': '#1=abort'}).begin(
        TWO_STEPS.replace('{id: second, @a2', '{id: second, @a2, retries: 1, retry_delay: 5.0')
    )
    run.go(until=0.5)
    run.ask(StopAfter('item', BY))
    run.go()
    assert run.starts('second') == [1.0, 7.0]
    assert run.times('cell.state_changed', state='Stopping') == [8.0]
    assert run.state.packml is PackmlState.STOPPED


def test_6_6_a_stop_to_come_is_taken_back() -> None:
    run = queued('K')
    run.ask(StopAfter('item', BY))
    run.go(until=3.0)
    assert run.ask(StopAfter('never', BY)).message == 'the line goes on'
    run.go()
    assert run.ended


def test_6_6_revoke_needs_a_pending_stop() -> None:
    answer = queued('').ask(StopAfter('never', BY))
    assert answer.message == 'there is nothing to take back: no stop was asked for'


def test_6_6_stop_after_needs_a_startable_job() -> None:
    run = VirtualRun(LINE.cell, LINE.types)
    run.add(('K', SCRIPT), held=True)
    assert not run.ask(StopAfter('job', BY)).accepted


def test_6_6_line_continues_after_stop_and_start() -> None:
    run = queued('K')
    run.go(until=1.5)
    run.ask(StopAfter('item', BY))
    run.go(until=60.0)
    run.add(('L', SCRIPT))
    run.command(Reset)
    run.command(Start)
    run.go()
    assert begun(run) == ['J', 'K', 'L']
    assert run.counts()['packed'] == 3
    assert run.ended
