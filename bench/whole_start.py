"""The start of a whole tree node, from its process on."""

from __future__ import annotations

import time
from pathlib import Path

from fakes.line import Line
from program_process import ProgramProcess
from ros_domain import OwnDomain


def process_s(journal: Path, folder: Path) -> float:
    """Return the seconds from the start of a tree node's process until it says it is ready.

    :param journal: of `fakes.line.Line`; made if it is not there, and none of its events removed
    :param folder: for the cell file, and for what the node prints
    """
    cell = folder / 'cell.yaml'
    cell.write_text(Line().text)
    words = ['run', '--cell', str(cell), '--journal', str(journal), '--journal-keep-jobs', '-1']
    with OwnDomain():
        began = time.perf_counter()
        node = ProgramProcess(words, folder, 'node')
        try:
            node.wait_ready()
            return time.perf_counter() - began
        finally:
            node.stop()
