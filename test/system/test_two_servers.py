"""Two servers under one action name, in processes of their own (semantics 2.5 and 9.3)."""

from __future__ import annotations

from typing import Any

import pytest
from cell_processes import CellProcesses, StartCell
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from program_process import ProgramProcess

STATUS = '/worker/task/_action/status'
"""Whoever publishes it is a server of the action."""

SHARES = ('feeder,packer,conveyor', 'worker')

SPEED = 5
"""At which the worker's TASK_C takes 8 s: longer than a goal in flight is left alone."""


@pytest.fixture
def cell(start_cell: StartCell) -> CellProcesses:
    """Give the small cell, whose worker is simulated in a process of its own."""
    cell = start_cell(shares=SHARES, speed=SPEED)
    cell.connect()
    return cell


def second_worker(cell: CellProcesses) -> ProgramProcess:
    """Start another server of the worker's action."""
    second = cell.start_sim('worker')
    cell.sims.append(second)
    second.wait_ready()
    return second


def worker(status: Any) -> Any:
    return next(c for c in status.components if c.name == 'worker')


def done_by_worker(cell: CellProcesses) -> list[str]:
    return [record['event'] for record in cell.goals(component='worker', task='TASK_A')]


def test_2_5_two_servers_of_one_name_block_goals(cell: CellProcesses) -> None:
    second = second_worker(cell)
    status = cell.watch.until_status(lambda s: worker(s).contested, 'the status to say so')
    assert not worker(status).ready
    assert worker(status).contested.startswith('2 servers of worker/task: ')

    cell.run_small()
    waits = cell.watch.until_status(
        lambda s: any('2 servers' in wait.reason for wait in s.sections[1].waits),
        'the wait that says so',
    )
    [wait] = waits.sections[1].waits
    assert (wait.kind, list(wait.components)) == ('readiness', ['worker'])
    assert wait.reason.startswith('waiting for worker to have one server; there are 2 servers of ')
    # Names and topics of a server come one by one: they are told apart by their ids in the end.
    status = cell.watch.until_status(
        lambda s: worker(s).contested.count('/sim_cell (id ') == 2, 'two equal names'
    )
    line = f'worker: {worker(status).contested}'
    cell.watch.ros.spin_until(lambda: diagnosed(cell) == (DiagnosticStatus.ERROR, line), line)
    _, text, _ = cell.verb('status')
    assert line in text
    assert done_by_worker(cell) == []

    assert second.stop() == 0
    assert cell.watch.until_ended('WO-1').packed == 1
    assert done_by_worker(cell).count('started') == 1
    cell.stop()


def test_9_3_a_goal_goes_on_beside_a_second_server(cell: CellProcesses) -> None:
    """The second one does not know it, and says so at every question."""
    cell.run_small(', repeatable: true', 'TASK_C')
    goal = cell.watch.until('task.started', task='work')['goal']
    cell.watch.ros.spin_until(lambda: cell.goals(event='started', goal=goal), 'the work to begin')
    second = second_worker(cell)
    cell.watch.until_status(lambda s: worker(s).contested, 'the second server to be seen')
    ended = cell.watch.until('task.succeeded', task='work')
    assert ended['goal'] == goal
    assert not cell.watch.seen('task.failed')
    assert len(cell.goals(component='worker', event='started')) == 1
    assert second.stop() == 0
    assert cell.watch.until_ended('WO-1').packed == 1
    cell.stop()


def test_2_5_killed_server_delays_successor_only_seconds(
    cell: CellProcesses,
) -> None:
    cell.sims[1].kill()
    cell.sims[1] = cell.start_sim('worker')
    cell.sims[1].wait_ready()
    cell.run_small()
    cell.watch.until('task.started', task='work')
    in_graph = cell.watch.ros.node.count_publishers(STATUS)
    assert in_graph == 2, 'the graph itself forgets a killed server after 20 s'
    assert cell.watch.until_ended('WO-1').packed == 1
    assert done_by_worker(cell).count('started') == 1
    cell.stop()


def diagnosed(cell: CellProcesses) -> tuple[bytes, str]:
    """Return what the next diagnostics say of the servers."""
    heard: list[Any] = []
    node = cell.watch.ros.node
    subscription = node.create_subscription(DiagnosticArray, '/diagnostics', heard.append, 10)
    cell.watch.ros.spin_until(lambda: heard, 'diagnostics')
    node.destroy_subscription(subscription)
    [servers] = [status for status in heard[0].status if status.name.endswith(': action servers')]
    return servers.level, servers.message
