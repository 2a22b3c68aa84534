"""What becomes of a job whose client, or whose node, is killed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from action_caller import ActionCaller
from action_msgs.msg import GoalStatus
from bt_orchestrator_interfaces.action import RunJob
from bt_orchestrator_interfaces.msg import WorkOrder
from cell_processes import CellProcesses, StartCell, small_script
from program_process import ProgramProcess
from run_job_client import READY

CLIENT = Path(__file__).parents[1] / 'run_job_client.py'

ASK_AGAIN_S = 1.0


def insist(ros: ActionCaller, ask: Callable[[], Any]) -> Any:
    """Ask until it is answered: the graph still shows the killed node, which hears nothing."""
    asked: list[Any] = []

    def is_answered() -> bool:
        asked.append(ask())
        return ros.spin_for(ASK_AGAIN_S, lambda: any(future.done() for future in asked))

    assert any(is_answered() for _ in range(20))
    return next(future.result() for future in asked if future.done())


def test_a_job_outlives_its_client(small_cell: CellProcesses) -> None:
    script = str(small_cell.script(small_script()))
    client = ProgramProcess(['A', script, '30'], small_cell.folder, 'client', [str(CLIENT)])
    try:
        client.wait_ready(READY)
        small_cell.watch.until('item.placed', job='A')
    finally:
        client.kill()
    assert small_cell.watch.until_ended('A', 60.0).packed == 30
    small_cell.run_small(order='B')
    assert small_cell.watch.until_ended('B').packed == 1
    small_cell.stop()


def test_job_outlives_node_but_goal_does_not(start_cell: StartCell, tmp_path: Path) -> None:
    journal = tmp_path / 'journal.sqlite3'
    cell = start_cell(run_options=['--journal', str(journal), '--auto-resume'])
    cell.connect()
    watch = cell.watch
    order = WorkOrder(order='A', script=str(cell.script(small_script(task='TASK_C'))), quantity=2)
    handle = watch.ros.start(f'{watch.name}/run_job', RunJob, RunJob.Goal(order=order, who='Ada'))
    first = handle.get_result_async()
    watch.until('task.started', task='work')
    cell.kill_and_restart_node()

    watch.until('orchestrator.started')
    asked = insist(watch.ros, handle.get_result_async)
    assert asked.status == GoalStatus.STATUS_UNKNOWN
    goal = RunJob.Goal(order=order, who='Ada')
    again = insist(watch.ros, lambda: watch.ros.request(f'{watch.name}/run_job', RunJob, goal))
    refused = insist(watch.ros, again.get_result_async).result
    assert refused.exit_status == 'refused'
    assert refused.message == 'order A was given before; choose another id'
    assert watch.until_ended('A', 60.0).packed == 2
    assert not first.done()
    cell.stop()
