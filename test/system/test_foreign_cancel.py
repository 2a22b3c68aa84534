"""A goal that another client takes away from the line, on real action servers (semantics 2.6)."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from action_caller import ActionCaller
from bt_orchestrator_interfaces.action import Component
from cell_processes import CellProcesses

pytestmark = pytest.mark.every_distro

OPTIONS = ', retries: 2, repeatable: true, on_failure: continue'


@pytest.fixture
def hmi() -> Iterator[ActionCaller]:
    """Give a client of the controllers that is no orchestrator."""
    caller = ActionCaller()
    yield caller
    caller.close()


def done_by_worker(cell: CellProcesses) -> list[tuple[str, str]]:
    """Return what the worker itself has recorded of its goals, as (event, goal)."""
    records = cell.goals(component='worker')
    return [(r['event'], r['goal']) for r in records if r['event'] in ('started', 'ended')]


def test_2_6_goal_cancelled_elsewhere_runs_once_and_is_held(
    small_cell: CellProcesses, hmi: ActionCaller
) -> None:
    cell = small_cell
    cell.run_small(OPTIONS, 'TASK_B')
    goal = cell.watch.until('task.started', task='work')['goal']
    cell.watch.ros.spin_until(lambda: cell.goals(event='started', goal=goal), 'the work to begin')
    answer = hmi.cancel_of_another('/worker/task', Component, goal)
    assert len(answer.goals_canceling) == 1

    hold = cell.watch.until_held()
    assert (hold.task, hold.item, hold.reason) == ('work', 'WO-1/1', 'in_doubt')
    assert hold.message.startswith('cancelled by somebody else')
    assert cell.goals(event='ended', goal=goal, status='canceled')
    once = [('started', goal), ('ended', goal)]
    assert done_by_worker(cell) == once

    assert cell.watch.answer(hold.id, 'mark_done').accepted
    job = cell.watch.until_ended('WO-1')
    assert (job.packed, job.nonconforming) == (1, 0)
    assert done_by_worker(cell) == once
    assert not cell.watch.seen('task.cancel_requested')
    assert not cell.watch.seen('task.retrying')
    cell.stop()
