"""Pictures of a running node, with its state."""

from __future__ import annotations

from cell_processes import StartCell, run_verb
from program_process import ProgramProcess


def test_picture_follows_state_to_end_of_job(
    start_cell: StartCell,
) -> None:
    cell = start_cell(fail=['worker.#1=abort'])
    cell.connect()
    cell.run_small()
    cell.watch.until_held()  # told, and not only recorded
    once, followed = cell.folder / 'once.svg', cell.folder / 'followed.svg'
    words = ['render', str(cell.folder / 'small.yaml'), '--cell', str(cell.cell), '--live', '-o']

    assert run_verb(cell.folder, *words, str(once)) == (0, '', '')
    assert '! HELD (hold 1)' in once.read_text()
    assert 'slot 2: WO-1/1' in once.read_text()

    following = ProgramProcess([*words, str(followed), '--every', '0.1'], cell.folder, 'follow')
    try:
        cell.watch.ros.spin_until(followed.exists, 'the first picture')
        assert '! HELD (hold 1)' in followed.read_text()
        assert cell.watch.answer('1', 'retry').accepted
        assert following.wait() == 0, following.errors
    finally:
        following.kill()
    assert 'WO-1 (small): Ended, 1 of 1 packed' in followed.read_text()
    cell.stop()
