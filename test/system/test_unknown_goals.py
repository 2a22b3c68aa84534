"""Goals at real servers that the journal does not know (semantics 2.5 and 9.2)."""

from __future__ import annotations

import uuid
from collections.abc import Iterator
from pathlib import Path

import pytest
from action_caller import ActionCaller
from bt_orchestrator_interfaces.action import Component
from cell_processes import CellProcesses, StartCell


@pytest.fixture
def hmi() -> Iterator[ActionCaller]:
    """Give a client of the controllers that is no orchestrator."""
    caller = ActionCaller()
    yield caller
    caller.close()


def test_9_2_goal_of_lost_journal_holds_cell(
    start_cell: StartCell, tmp_path: Path, hmi: ActionCaller
) -> None:
    journal = tmp_path / 'cell' / 'journal.sqlite3'
    cell = start_cell(run_options=['--journal', str(journal), '--auto-resume'])
    cell.connect()
    cell.run_small(task='TASK_B')
    goal = cell.watch.until('task.started', task='work')['goal']
    cell.watch.ros.spin_until(lambda: cell.goals(event='started', goal=goal), 'the work to begin')
    cell.node.kill()
    for file in journal.parent.glob('journal.sqlite3*'):
        file.unlink()
    cell.start_node()
    cell.node.wait_ready()
    cell.watch.connect_anew()

    status = cell.watch.until_status(lambda s: s.holds, 'a hold')
    [hold] = status.holds
    assert hold.reason == 'unknown_goal'
    assert hold.message.startswith(f'worker/task at /sim_cell runs goal {goal}, accepted ')
    cell.run_small(order='WO-2')
    assert not cell.watch.command('resume').accepted
    assert len(cell.goals(event='started')) == 3, 'feed, the first move, and the goal that runs'

    assert cell.watch.command('resume', hold=hold.id).accepted
    waits = cell.watch.until_status(lambda s: s.sections[1].waits, 'section 2 to wait')
    cell.watch.ros.spin_until(
        lambda: goal in str(cell.watch.status.sections[1].waits), f'a wait for {goal}: {waits}'
    )
    hmi.cancel_of_another('/worker/task', Component, goal)
    assert cell.watch.until_ended('WO-2').packed == 1
    cell.stop()


def test_2_5_a_goal_of_another_client_is_waited_for(
    small_cell: CellProcesses, hmi: ActionCaller
) -> None:
    cell = small_cell
    # Four seconds of work: nobody takes it any more for a goal of before the node came.
    cell.run_small(task='TASK_C', quantity=2, order='WO-1')
    assert cell.watch.until_ended('WO-1').packed == 2
    request = hmi.request('/worker/task', Component, Component.Goal(task=Component.Goal.TASK_B))
    handle = hmi.wait(request, 'the goal to be accepted')
    foreign = str(uuid.UUID(bytes=bytes(handle.goal_id.uuid)))
    status = cell.watch.until_status(
        lambda s: any(foreign in c.contested for c in s.components), 'the goal to be seen'
    )
    assert not status.holds
    cell.run_small(order='WO-2')
    wait = f'waiting for worker; it runs goal {foreign}, which no task here waits for'
    cell.watch.until_status(
        lambda s: wait in [entry.reason for entry in s.sections[1].waits], 'the wait that names it'
    )
    hmi.wait(handle.cancel_goal_async(), 'the cancel')
    assert cell.watch.until_ended('WO-2').packed == 1
    cell.stop()
