"""The program of docs/python_api.md, as it stands there, at the door of a cell."""

from __future__ import annotations

import re
from pathlib import Path

from cell_processes import ROOT, CellProcesses
from program_process import ProgramProcess


def test_a_program_at_the_door_follows_and_asks(small_cell: CellProcesses, tmp_path: Path) -> None:
    page = (ROOT / 'docs' / 'python_api.md').read_text(encoding='utf-8')
    (text,) = re.findall(r'^```python\n(.*?)^```$', page, re.MULTILINE | re.DOTALL)
    (tmp_path / 'three_items.py').write_text(text)
    program = ProgramProcess([], tmp_path, 'three_items', [str(tmp_path / 'three_items.py')])
    try:
        program.wait_ready('\n')  # a status: it hears the cell
        small_cell.run_small(quantity=40)

        assert program.wait() == 0, program.errors
        small_cell.watch.until_held()
        assert 'Execute\n' in program.output
        assert len(small_cell.watch.seen('item.removed')) < 40
    finally:
        program.kill()
    small_cell.stop()
