"""Ending the tree node while goals run (semantics 2.6)."""

from __future__ import annotations

import signal

import patient_node
import pytest
from cell_processes import STATELESS_CELL, CellProcesses, StartCell

pytestmark = pytest.mark.every_distro

PATIENT = [patient_node.__file__]
"""A node that ends because it has to wait no longer, and not because its time is over."""


def run_long_task(cell: CellProcesses, task: str = 'TASK_B') -> str:
    """Run the worker's task of a minute, and return its goal once the server is at it."""
    cell.run_small(', retries: 3, on_failure: continue', task)
    goal = str(cell.watch.until('task.started', task='work')['goal'])
    cell.watch.ros.spin_until(lambda: cell.goals(event='started', goal=goal), 'the goal to run')
    return goal


def signalled(cell: CellProcesses, with_signal: signal.Signals) -> int:
    """Stop the node, and return its exit status."""
    cell.node.send(with_signal)
    return cell.node.wait()


def connected(cell: CellProcesses) -> CellProcesses:
    cell.connect()
    return cell


@pytest.mark.parametrize('with_signal', [signal.SIGINT, signal.SIGTERM])
def test_signal_cancels_goals_and_node_exits_0(
    start_cell: StartCell, with_signal: signal.Signals
) -> None:
    cell = connected(start_cell(node_program=PATIENT))
    goal = run_long_task(cell)

    assert signalled(cell, with_signal) == 0
    assert cell.goals(event='cancel', goal=goal, obeyed=True)
    assert cell.goals(event='ended', goal=goal, status='canceled')
    cell.stop()


def test_the_last_events_tell_what_the_signal_did(small_cell: CellProcesses) -> None:
    goal = run_long_task(small_cell)
    small_cell.node.send(signal.SIGINT)

    watch = small_cell.watch
    watch.until('cell.state_changed', state='Stopped')
    assert watch.until('task.cancel_requested')['cause'] == 'shutdown'
    assert watch.until('task.failed', goal=goal)['reason'] == 'canceled'
    assert not watch.seen('task.retrying'), 'the own cancel is no failed attempt'
    assert not watch.seen('task.continued')
    small_cell.stop()


def test_a_node_without_goals_ends_at_once(start_cell: StartCell) -> None:
    cell = connected(start_cell(node_program=PATIENT))
    assert signalled(cell, signal.SIGTERM) == 0
    cell.stop()


STUBBORN = ['worker.TASK_B=ignore_cancel']
"""A worker that ignores cancel requests."""


def test_node_names_goal_ignoring_cancel_and_exits_1(
    start_cell: StartCell,
) -> None:
    cell = connected(start_cell(fail=STUBBORN))
    goal = run_long_task(cell)

    assert signalled(cell, signal.SIGINT) == 1
    assert f'work of WO-1/1 (goal {goal})' in cell.node.errors
    assert cell.goals(event='cancel', goal=goal, obeyed=False)
    cell.stop(node_status=1)


def test_a_second_signal_ends_the_node_at_once(start_cell: StartCell) -> None:
    cell = connected(start_cell(fail=STUBBORN, node_program=PATIENT))
    goal = run_long_task(cell)
    cell.node.send(signal.SIGINT)
    cell.watch.until('task.cancel_requested', goal=goal)

    assert signalled(cell, signal.SIGINT) == 1
    assert f'work of WO-1/1 (goal {goal})' in cell.node.errors
    cell.stop(node_status=1)


def test_goal_waiting_for_server_is_withdrawn(start_cell: StartCell) -> None:
    cell = start_cell(STATELESS_CELL, fail=['worker.=absent'], node_program=PATIENT)
    cell.connect(wait_servers=False)
    cell.watch.wait_servers(but='worker')
    cell.run_small()
    cell.watch.until('task.started', task='work')

    assert signalled(cell, signal.SIGINT) == 0
    cell.stop()
