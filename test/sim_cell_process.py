"""A simulated cell in a process of its own, for tests."""

from __future__ import annotations

import json
import queue
import signal
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

from patience import PATIENCE_S

_PROGRAM = 'import sys; from bt_orchestrator.cli.sim_cell import sim_cell_main as m; sys.exit(m())'


class SimCellProcess:
    """States: starting, ready (after `wait_until_ready`), ended (after `stop`)."""

    def __init__(self, cell: Path, *options: str) -> None:
        self.log = cell.with_suffix('.jsonl')
        command = [sys.executable, '-c', _PROGRAM, '--cell', str(cell), '--log', str(self.log)]
        self._process = subprocess.Popen(
            [*command, *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        self._lines: queue.Queue[str] = queue.Queue()
        self.errors: list[str] = []
        self._readers = [
            threading.Thread(target=self._read_output),
            threading.Thread(target=self._read_errors),
        ]
        for reader in self._readers:
            reader.start()

    def wait_until_ready(self) -> str:
        """Return the ready line."""
        line = self._lines.get(timeout=PATIENCE_S)
        assert line.startswith('sim-cell ready: '), f'{line!r} {"".join(self.errors)}'
        return line.strip()

    def stop(self, with_signal: signal.Signals = signal.SIGINT) -> int:
        """Ask it to end, and return its exit status; harmless if it has ended."""
        if self._process.poll() is None:
            self._process.send_signal(with_signal)
        return self.wait()

    def wait(self) -> int:
        """Return its exit status, once it has ended."""
        try:
            return self._process.wait(PATIENCE_S)
        finally:
            self._process.kill()
            for reader in self._readers:
                reader.join()
            for pipe in (self._process.stdout, self._process.stderr):
                assert pipe is not None
                pipe.close()

    def records(self, **about: Any) -> list[dict[str, Any]]:
        """Return the records of the goal log that have these values."""
        lines = self.log.read_text().splitlines() if self.log.exists() else []
        records = [json.loads(line) for line in lines]
        return [r for r in records if about.items() <= r.items()]

    def _read_output(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            self._lines.put(line)
        self._lines.put('')

    def _read_errors(self) -> None:
        assert self._process.stderr is not None
        self.errors.extend(self._process.stderr)
