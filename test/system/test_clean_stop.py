"""Ending the tree node while goals run (semantics 2.6)."""

from __future__ import annotations

import signal
import time

import pytest
from cell_processes import STATELESS_CELL, CellProcesses, StartCell

from bt_orchestrator.ros.node import FAREWELL_S

pytestmark = pytest.mark.every_distro

SLACK_S = 8.0
"""For leaving ROS, on a busy machine; less than a farewell takes."""


def run_long_task(cell: CellProcesses, task: str = 'TASK_B') -> str:
    """Run the worker's task of a minute, and return its goal once the server is at it."""
    cell.run_small(', retries: 3, on_failure: continue', task)
    goal = str(cell.watch.until('task.started', task='work')['goal'])
    cell.watch.ros.spin_until(lambda: cell.goals(event='started', goal=goal), 'the goal to run')
    return goal


def signalled(cell: CellProcesses, with_signal: signal.Signals, within_s: float) -> int:
    """Stop the node, and return its exit status; fails if that takes too long."""
    cell.node.send(with_signal)
    return cell.node.wait(within_s)


@pytest.mark.parametrize('with_signal', [signal.SIGINT, signal.SIGTERM])
def test_a_signal_cancels_the_goals_and_ends_the_node_with_0(
    small_cell: CellProcesses, with_signal: signal.Signals
) -> None:
    goal = run_long_task(small_cell)

    assert signalled(small_cell, with_signal, FAREWELL_S) == 0
    assert small_cell.goals(event='cancel', goal=goal, obeyed=True)
    assert small_cell.goals(event='ended', goal=goal, status='canceled')
    small_cell.stop()


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


def test_a_node_without_goals_ends_at_once(small_cell: CellProcesses) -> None:
    assert signalled(small_cell, signal.SIGTERM, SLACK_S) == 0
    small_cell.stop()


@pytest.fixture
def stubborn_cell(start_cell: StartCell) -> CellProcesses:
    """Give a cell whose worker ignores cancel requests."""
    cell = start_cell(fail=['worker.TASK_B=ignore_cancel'])
    cell.connect()
    return cell


def test_a_goal_that_ignores_its_cancel_is_named_and_the_status_is_1(
    stubborn_cell: CellProcesses,
) -> None:
    goal = run_long_task(stubborn_cell)

    assert signalled(stubborn_cell, signal.SIGINT, FAREWELL_S + SLACK_S) == 1
    assert f'work of WO-1/1 (goal {goal})' in stubborn_cell.node.errors
    assert stubborn_cell.goals(event='cancel', goal=goal, obeyed=False)
    stubborn_cell.stop(node_status=1)


def test_a_second_signal_ends_the_node_at_once(stubborn_cell: CellProcesses) -> None:
    goal = run_long_task(stubborn_cell)
    stubborn_cell.node.send(signal.SIGINT)
    stubborn_cell.watch.until('task.cancel_requested', goal=goal)

    before = time.monotonic()
    assert signalled(stubborn_cell, signal.SIGINT, SLACK_S) == 1
    assert time.monotonic() - before < SLACK_S
    assert f'work of WO-1/1 (goal {goal})' in stubborn_cell.node.errors
    stubborn_cell.stop(node_status=1)


def test_a_goal_that_waits_for_its_server_is_withdrawn(start_cell: StartCell) -> None:
    cell = start_cell(STATELESS_CELL, fail=['worker.=absent'])
    cell.connect(wait_servers=False)
    cell.watch.wait_servers(but='worker')
    cell.run_small()
    cell.watch.until('task.started', task='work')

    assert signalled(cell, signal.SIGINT, SLACK_S) == 0
    cell.stop()
