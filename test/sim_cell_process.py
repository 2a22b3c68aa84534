"""A simulated cell in a process of its own, for tests."""

from __future__ import annotations

import json
from itertools import count
from pathlib import Path
from typing import Any

from program_process import PROGRAM, ProgramProcess

_OF_LAUNCH_FILES = (
    '-c',
    'import sys; from bt_orchestrator.cli.sim_cell import sim_cell_main as m; sys.exit(m())',
)
"""The program that takes arguments of ROS, which the verb does not."""

_numbers = count()


class SimCellProcess(ProgramProcess):
    """Serves the actions of a cell, and keeps a log of their goals beside its file."""

    def __init__(self, cell: Path, *options: str) -> None:
        self.log = cell.with_suffix('.jsonl')
        words = ['--cell', str(cell), '--log', str(self.log), *options]
        is_launched = '--ros-args' in options
        super().__init__(
            words if is_launched else ['sim-cell', *words],
            cell.parent,
            f'sim_cell_{next(_numbers)}',
            _OF_LAUNCH_FILES if is_launched else PROGRAM,
        )

    def records(self, **about: Any) -> list[dict[str, Any]]:
        """Return the records of the goal log that have these values."""
        lines = self.log.read_text().splitlines() if self.log.exists() else []
        records = [json.loads(line) for line in lines]
        return [r for r in records if about.items() <= r.items()]
