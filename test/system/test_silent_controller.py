"""A controller that is there and does not answer, on the real tree node (semantics 9.3)."""

from __future__ import annotations

from pathlib import Path

from cell_processes import STATELESS_CELL, StartCell, run_verb
from mute_server import READY
from program_process import ProgramProcess

MUTE_SERVER = Path(__file__).parents[1] / 'mute_server.py'


def test_9_3_silent_controller_leaves_task_in_doubt(start_cell: StartCell, tmp_path: Path) -> None:
    cell = start_cell(STATELESS_CELL, shares=['feeder,packer,conveyor'])
    mute = ProgramProcess(['worker/task'], tmp_path, 'mute', [str(MUTE_SERVER)])
    try:
        mute.wait_ready(READY)
        cell.connect()
        cell.run_small(', repeatable: true')
        hold = cell.watch.until_held()
        assert (hold.task, hold.reason) == ('work', 'in_doubt')
        assert 'the server of worker/task is there and does not answer' in hold.message
        assert (hold.topic_says, hold.answers[0]) == ('succeeded', 'mark_done')
        assert 'asked through a fresh participant' in cell.node.errors
        words = ['answer', hold.id, 'mark_done', '--reason', 'looked']
        assert run_verb(cell.folder, *words)[0] == 0
        assert cell.watch.until_ended('WO-1').packed == 1
        cell.stop()
    finally:
        mute.kill()
