"""What the simulated servers did, read from their log while they write it."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from itertools import takewhile
from pathlib import Path
from typing import Any

PATIENCE_S = 60.0


class Tail:
    """Reads what the servers write to their log from now on, and no line twice."""

    def __init__(self, log: Path) -> None:
        self._log = log
        self._offset = log.read_bytes().rfind(b'\n') + 1  # a line may be half written
        self.records: list[dict[str, Any]] = []
        self.ended = 0
        """How many tasks ended, the moves of the belt left out."""

    def until_ended(self, tasks: int, patience_s: float = PATIENCE_S) -> None:
        """Read until so many tasks have ended."""
        until(lambda: self._read() >= tasks, f'{tasks} tasks', patience_s)

    def _read(self) -> int:
        with self._log.open('rb') as file:
            file.seek(self._offset)
            # Behind a half written line may come its other half, written since.
            for line in takewhile(_is_whole, file):
                self._offset += len(line)
                self._take(json.loads(line))
        return self.ended

    def _take(self, record: dict[str, Any]) -> None:
        self.records.append(record)
        self.ended += record['event'] == 'ended' and record['component'] != 'conveyor'


def _is_whole(line: bytes) -> bool:
    return line.endswith(b'\n')


def until(condition: Callable[[], bool], what: str, patience_s: float = PATIENCE_S) -> None:
    """Look at a condition until it holds."""
    deadline = time.monotonic() + patience_s
    while not condition():
        if time.monotonic() > deadline:
            raise TimeoutError(f'waited {patience_s:g} s for {what}')
        time.sleep(0.05)
