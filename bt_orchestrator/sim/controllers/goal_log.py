"""The real work of the simulated controllers, one JSON object a line."""

from __future__ import annotations

import json
from pathlib import Path
from time import monotonic
from typing import Any

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.model.cell import Component


class UnusableLog(OrchestratorError):
    """The file cannot be written."""


class GoalLog:
    """Appends one line an event to a file; nothing without a file.

    A line is written at once and in one piece, before its effect leaves the process, so that
    several processes can share a file and a killed one leaves no half told story. Records:

    - `accepted`, `rejected` (with `why`), `muted`: how a goal request was answered
    - `started`: the work began; `ended` (with `status`): it is over, as the server will report it
    - `cancel` (with `obeyed`): a cancel request came
    - `died`: the server went away, with the goal it had, if any; `appeared`: it is (again) there

    Every record has `time` (seconds since the epoch, or simulated time), `steady` (seconds of the
    machine's monotonic clock, for measuring), `event`, `component` and `action`; those about a
    goal also `goal` (its UUID) and `task`.
    """

    def __init__(self, path: Path | None) -> None:
        """Open the file.

        :raises UnusableLog: it cannot be written
        """
        try:
            # Without a buffer each line is handed to the system in one write.
            self._file = None if path is None else path.open('ab', buffering=0)
        except OSError as error:
            raise UnusableLog(
                f'cannot write the log {path}: {error.strerror}; check the path'
            ) from error

    def write(self, time: float, event: str, component: Component, **fields: Any) -> None:
        """Append one record.

        :raises UnusableLog: it cannot be written
        """
        if self._file is None:
            return
        where = {'component': component.name, 'action': component.action}
        stamps = {'time': round(time, 6), 'steady': round(monotonic(), 6)}
        record = {**stamps, 'event': event, **where, **fields}
        try:
            self._file.write(f'{json.dumps(record)}\n'.encode())
        except OSError as error:
            raise UnusableLog(f'cannot write the log: {error.strerror}; check its disk') from error

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            self._file.close()
