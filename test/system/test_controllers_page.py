"""The controller of docs/controllers.md, as it stands there, on a line."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from cell_processes import ROOT, CellProcesses, StartCell
from program_process import ProgramProcess

MOST_LINES = 30


def shown(language: str) -> list[str]:
    """Return the blocks of the page in a language."""
    page = (ROOT / 'docs' / 'controllers.md').read_text(encoding='utf-8')
    return re.findall(rf'^```{language}\n(.*?)^```$', page, re.MULTILINE | re.DOTALL)


@pytest.fixture
def line(start_cell: StartCell, tmp_path: Path) -> Iterator[CellProcesses]:
    (program,) = shown('python')
    assert len(list(filter(None, program.splitlines()))) <= MOST_LINES
    (tmp_path / 'drill.py').write_text(program)
    cell = start_cell(shown('yaml')[0], shares=('conveyor,loader,packer',))
    drill = ProgramProcess([], tmp_path, 'drill', [str(tmp_path / 'drill.py')])
    cell.connect()
    yield cell
    drill.kill()


def test_2_2_a_controller_of_thirty_lines_does_its_task(line: CellProcesses) -> None:
    line.watch.submit(line.script(shown('yaml')[1], 'drilled'), quantity=2)

    job = line.watch.until_ended('WO-1')
    assert (job.packed, job.nonconforming, job.rejected) == (2, 0, 0)
    done = line.watch.until('task.succeeded', item='WO-1/2', task='drill')
    assert done['results']['measurement'] == 10.2
    line.stop()


def test_2_4_it_is_cancelled_when_its_time_is_over(line: CellProcesses) -> None:
    script = shown('yaml')[1].replace('retries: 1', 'timeout: 0.4, on_failure: reject')
    line.watch.submit(line.script(script, 'drilled'))

    job = line.watch.until_ended('WO-1')
    assert (job.packed, job.rejected) == (0, 1)
    failed = line.watch.until('task.failed', task='drill')
    assert failed['reason'] == 'timeout'
    assert ' of 10 mm' in failed['last_feedback']
    line.stop()
