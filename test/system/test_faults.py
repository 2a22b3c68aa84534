"""Every fault of a real action server: its reason, and what the policy makes of it."""

from __future__ import annotations

from typing import Any

import pytest
from cell_processes import SMALL_CELL, STATELESS_CELL, CellProcesses, StartCell
from worker_state import SAYS_NOTHING, WorkerState

from bt_orchestrator.engine.runtime.flights import GRACE_S
from bt_orchestrator.model.goal import SERVER_LEASE_S


def start(
    start_cell: StartCell, *faults: str, text: str = SMALL_CELL, **options: Any
) -> CellProcesses:
    """Start a small cell with faults of its worker."""
    cell = start_cell(text, fail=[f'worker.{fault}' for fault in faults], **options)
    cell.connect(wait_servers=False)
    cell.watch.wait_servers(but='worker')
    return cell


def worker(status: Any) -> Any:
    return next(c for c in status.components if c.name == 'worker')


def attempts(cell: CellProcesses, order: str = 'WO-1') -> list[int]:
    started = cell.watch.seen('task.started', task='work', job=order)
    return [event['attempt'] for event in started]


def reasons(cell: CellProcesses, order: str = 'WO-1') -> list[str]:
    """Return why the attempts at the work of an order failed, in order."""
    return [event['reason'] for event in cell.watch.seen('task.failed', task='work', job=order)]


def assert_held(cell: CellProcesses, reason: str, order: str = 'WO-1') -> str:
    """Wait until the cell is Held by the work's failure, and return the hold."""
    hold = cell.watch.until_held()
    assert (hold.section, hold.item, hold.task, hold.reason) == (2, f'{order}/1', 'work', reason)
    assert reasons(cell, order)[-1] == reason
    raised = cell.watch.seen('hold.raised')[-1]
    assert (raised['hold'], raised['reason']) == (hold.id, reason)
    return str(hold.id)


def assert_made(cell: CellProcesses, order: str, *, nonconforming: int = 0) -> None:
    """Wait for the end of an order, whose one item is packed."""
    job = cell.watch.until_ended(order)
    assert (job.packed, job.nonconforming, job.rejected) == (1, nonconforming, 0)


def assert_packed(cell: CellProcesses, *, nonconforming: int = 0) -> None:
    """Wait for the end of the only order, and end everything."""
    assert_made(cell, 'WO-1', nonconforming=nonconforming)
    cell.stop()


# --- ends that the server reports, and a limit that it keeps ------------------------------------


def test_ends_of_goals(start_cell: StartCell) -> None:
    """The worker's goals are counted over all orders: an attempt is one of them."""
    numbers = (1, 'reject'), (3, 'abort'), (5, 'abort'), (6, 'reject'), (8, 'false'), (9, 'hang')
    cell = start(start_cell, *(f'TASK_A#{number}={fault}' for number, fault in numbers))
    _a_failed_attempt_is_repeated(cell, 'rejected', 'goal_rejected')
    _a_failed_attempt_is_repeated(cell, 'aborted', 'aborted')
    _when_no_retry_is_left_the_section_holds_until_it_is_answered(cell)
    _with_continue_the_item_is_packed_nonconforming(cell)
    _at_its_timeout_a_goal_is_cancelled_and_then_repeated(cell)
    cell.stop()


def _a_failed_attempt_is_repeated(cell: CellProcesses, order: str, reason: str) -> None:
    held = len(cell.watch.seen('hold.raised'))
    cell.run_small(', retries: 1', order=order)

    assert_made(cell, order)
    assert reasons(cell, order) == [reason]
    assert attempts(cell, order) == [1, 2]
    retrying = cell.watch.seen('task.retrying', job=order)
    assert [event['attempt'] for event in retrying] == [2]
    assert len(cell.watch.seen('hold.raised')) == held


def _when_no_retry_is_left_the_section_holds_until_it_is_answered(cell: CellProcesses) -> None:
    cell.run_small(', retries: 1', order='held')

    hold = assert_held(cell, 'goal_rejected', 'held')
    assert reasons(cell, 'held') == ['aborted', 'goal_rejected']
    assert cell.watch.answer(hold, 'retry').accepted
    assert_made(cell, 'held')
    assert attempts(cell, 'held') == [1, 2, 3]


def _with_continue_the_item_is_packed_nonconforming(cell: CellProcesses) -> None:
    cell.run_small(', continue_if_fail: true', order='continued')

    assert_made(cell, 'continued', nonconforming=1)
    assert reasons(cell, 'continued') == ['task_result_false']
    assert [e['policy'] for e in cell.watch.seen('task.continued', task='work')] == ['continue']


def _at_its_timeout_a_goal_is_cancelled_and_then_repeated(cell: CellProcesses) -> None:
    cell.run_small(', timeout: 0.5, retries: 1', order='late')

    assert_made(cell, 'late')
    (asked,) = cell.watch.seen('task.cancel_requested')
    assert asked['cause'] == 'timeout'
    assert cell.goals(event='cancel', goal=asked['goal'], obeyed=True)
    assert reasons(cell, 'late') == ['timeout']
    failed = cell.watch.until('task.failed', job='late')
    assert failed['time'] - asked['time'] < GRACE_S


# --- a goal that nobody can end -----------------------------------------------------------------


@pytest.fixture
def doubtful_cell(start_cell: StartCell) -> CellProcesses:
    """Give a cell whose worker went on with a goal that was cancelled at its timeout."""
    cell = start(start_cell, 'TASK_A=ignore_cancel')
    cell.run_small(', timeout: 0.5, retries: 1, on_failure: continue')
    assert_held(cell, 'in_doubt')
    return cell


def test_task_without_end_after_cancel_is_in_doubt(
    doubtful_cell: CellProcesses,
) -> None:
    cell = doubtful_cell
    (asked,) = cell.watch.seen('task.cancel_requested')
    failed = cell.watch.until('task.failed')
    assert GRACE_S <= failed['time'] - asked['time'] < 2 * GRACE_S
    assert attempts(cell) == [1]
    assert worker(cell.watch.status).task == 'work of WO-1/1', 'the component stays reserved'

    (hold,) = cell.watch.status.holds
    assert cell.watch.answer(hold.id, 'mark_done').accepted
    assert_packed(cell)
    assert cell.watch.seen('task.marked_done', task='work')
    assert attempts(cell) == [1]


def test_server_may_reject_retry_of_task_in_doubt(
    doubtful_cell: CellProcesses,
) -> None:
    cell = doubtful_cell
    (hold,) = cell.watch.status.holds
    assert cell.watch.answer(hold.id, 'retry').accepted

    assert_packed(cell, nonconforming=1)
    assert reasons(cell) == ['in_doubt', 'goal_rejected']
    goals = [event['goal'] for event in cell.watch.seen('task.started', task='work')]
    assert len(set(goals)) == 2, 'a new attempt has a new UUID'
    assert cell.goals(event='rejected', goal=goals[1])


# --- servers that vanish ----------------------------------------------------------------------


def test_servers_that_vanish(start_cell: StartCell) -> None:
    """The worker's goals are counted over all orders; after the last one it does not come back."""
    numbers = (1, 'mute'), (3, 'die:2'), (5, 'die:2'), (7, 'die')
    cell = start(start_cell, *(f'TASK_A#{number}={fault}' for number, fault in numbers))
    _a_request_that_is_never_answered_is_lost(cell)
    _a_lost_task_that_may_be_repeated_is(cell)
    _a_server_that_died_and_came_back_has_lost_the_task(cell)
    _a_server_that_died_and_stays_away_has_lost_the_task(cell)
    cell.stop()


def _a_request_that_is_never_answered_is_lost(cell: CellProcesses) -> None:
    cell.run_small(', retries: 1, on_failure: continue', order='mute')

    hold = assert_held(cell, 'server_lost', 'mute')
    assert attempts(cell, 'mute') == [1], 'neither retry nor policy: nobody knows what was done'
    assert cell.watch.answer(hold, 'retry').accepted
    assert_made(cell, 'mute')


def _a_lost_task_that_may_be_repeated_is(cell: CellProcesses) -> None:
    held = len(cell.watch.seen('hold.raised'))
    cell.run_small(', retries: 1, repeatable: true', order='repeated')

    assert_made(cell, 'repeated')
    assert reasons(cell, 'repeated') == ['server_lost']
    assert attempts(cell, 'repeated') == [1, 2]
    assert len(cell.watch.seen('hold.raised')) == held


def _a_server_that_died_and_came_back_has_lost_the_task(cell: CellProcesses) -> None:
    cell.run_small(', retries: 1, on_failure: continue', order='back')

    hold = assert_held(cell, 'server_lost', 'back')
    failed = cell.watch.until('task.failed', job='back')
    started = cell.watch.until('task.started', task='work', job='back')
    assert failed['time'] - started['time'] < SERVER_LEASE_S / 2
    assert attempts(cell, 'back') == [1]
    assert cell.watch.answer(hold, 'retry').accepted
    assert_made(cell, 'back')


def _a_server_that_died_and_stays_away_has_lost_the_task(cell: CellProcesses) -> None:
    cell.run_small(', retries: 1, on_failure: continue', order='away')

    hold = assert_held(cell, 'server_lost', 'away')
    status = cell.watch.until_status(lambda s: not worker(s).available, 'the worker to be missed')
    assert [c.name for c in status.components if not c.available] == ['worker']
    assert cell.watch.answer(hold, 'skip').accepted
    assert_made(cell, 'away')


def test_goal_waits_for_late_server(start_cell: StartCell) -> None:
    options = ['--ros-args', '-p', 'server_timeout:=30.0']
    shares = ['conveyor,feeder,packer']
    cell = start(start_cell, text=STATELESS_CELL, shares=shares, run_options=options)
    cell.run_small()

    started = cell.watch.until('task.started', task='work')
    cell.sims.append(cell.start_sim('worker'))
    assert_packed(cell)
    assert reasons(cell) == []
    (appeared,) = cell.goals(event='appeared', component='worker')
    assert started['time'] < appeared['time']


def test_a_server_that_never_comes_is_unavailable(start_cell: StartCell) -> None:
    options = ['--ros-args', '-p', 'server_timeout:=0.5']
    cell = start(start_cell, '=absent', text=STATELESS_CELL, run_options=options)
    cell.run_small(', on_failure: continue')

    assert_packed(cell, nonconforming=1)
    assert reasons(cell) == ['server_unavailable']


KILLED = '/killed'
"""Namespace of cells with a process that is killed: its servers haunt the graph for a while."""


def kill_the_worker(start_cell: StartCell, options: str) -> CellProcesses:
    """Run a task of two seconds, and kill the process of its server in the middle."""
    cell = start(start_cell, shares=('conveyor,feeder,packer', 'worker'), namespace=KILLED)
    cell.run_small(options, 'TASK_C')
    cell.watch.ros.spin_until(lambda: cell.goals(event='started', component='worker'), 'the goal')
    cell.sims.pop().kill()
    return cell


def test_killed_and_restarted_server_has_lost_task(start_cell: StartCell) -> None:
    cell = kill_the_worker(start_cell, ', repeatable: true, retries: 1')
    killed = cell.watch.until('task.started', task='work')
    cell.sims.append(cell.start_sim('worker'))

    assert_packed(cell)
    assert reasons(cell) == ['server_lost']
    failed = cell.watch.until('task.failed')
    assert failed['time'] - killed['time'] < 0.9 * SERVER_LEASE_S, 'the graph need not forget it'


def test_killed_server_is_lost_once_graph_forgets_it(
    start_cell: StartCell,
) -> None:
    cell = kill_the_worker(start_cell, ', retries: 1')
    cell.watch.ros.spin_for(2 * SERVER_LEASE_S, lambda: cell.watch.seen('task.failed'))

    hold = assert_held(cell, 'server_lost')
    assert not worker(cell.watch.status).available
    assert cell.watch.answer(hold, 'mark_done').accepted
    assert_packed(cell)


# --- readiness --------------------------------------------------------------------------------


def wait_for_ready(cell: CellProcesses, since_seq: int = 0) -> Any:
    """Wait until the second section waits for its worker's readiness, and return the status.

    :param since_seq: an event that the status must know of
    """
    reason = 'waiting for worker/state = READY'
    return cell.watch.until_status(
        lambda s: (
            s.seq >= since_seq and any(reason in wait.reason for wait in s.sections[1].waits)
        ),
        reason,
    )


def test_component_not_ready_at_first_is_awaited(start_cell: StartCell) -> None:
    cell = start_cell(fail=[SAYS_NOTHING])
    cell.connect()
    state = WorkerState(cell)
    cell.run_small()

    wait_for_ready(cell)
    status = cell.watch.until_status(lambda s: worker(s).state, 'the state of the worker')
    component = worker(status)
    assert (component.ready, component.state, component.available) == (False, 'NOT_READY', True)
    assert not cell.watch.seen('task.started', task='work')
    state.be_ready()
    assert_packed(cell)
    changes = cell.watch.seen('component.state_changed', component='worker')
    assert changes[-1]['ready']
    assert changes[-1]['seq'] < cell.watch.until('task.started', task='work')['seq']


def test_a_component_that_becomes_unready_is_waited_for(start_cell: StartCell) -> None:
    cell = start(start_cell, '#1=not_ready:60')
    cell.run_small(quantity=2)

    packed = cell.watch.until('item.removed', item='WO-1/1')
    wait_for_ready(cell, packed['seq'])
    assert [event['item'] for event in cell.watch.seen('task.started', task='work')] == ['WO-1/1']
    assert cell.watch.until_ended('WO-1').packed == 2
    cell.stop()


def test_a_silent_component_is_never_sent_a_goal(start_cell: StartCell) -> None:
    cell = start(start_cell, '=silent')
    cell.run_small()

    component = worker(wait_for_ready(cell))
    assert (component.ready, component.state) == (False, '')
    assert not cell.goals(component='worker', event='accepted')
    cell.stop()
