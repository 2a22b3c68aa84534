"""Other programs, started for a while and ended without leftovers."""

from __future__ import annotations

import os
import queue
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

from bt_orchestrator.base.errors import OrchestratorError

FAREWELL_S = 15.0
"""Longest time that a program has to end by itself; longer than the node takes at most."""


class ProgramFailed(OrchestratorError):
    """A program ended, or said nothing, when it should have been ready."""


class Program:
    """One verb of this program in a process of its own; what it prints goes to a log file.

    A process group of its own: Ctrl-C in a terminal reaches this program alone, which then ends
    the others in order.
    """

    def __init__(self, verb: Sequence[str], log: Path, environment: Mapping[str, str]) -> None:
        self.name = verb[0]
        self._log = log
        self._lines: queue.SimpleQueue[str | None] = queue.SimpleQueue()
        with log.open('ab') as errors:
            self._process = subprocess.Popen(
                [sys.executable, '-m', 'bt_orchestrator', *verb],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=errors,
                env={**os.environ, **environment},
                text=True,
                start_new_session=True,
            )
        self._reader = threading.Thread(target=self._read, name=f'{self.name} output', daemon=True)
        self._reader.start()

    @property
    def pid(self) -> int:
        """Process id."""
        return self._process.pid

    @property
    def ended(self) -> bool:
        """Tell whether the process is gone."""
        return self._process.poll() is not None

    def wait_ready(self, word: str, timeout_s: float) -> str:
        """Return the line that holds a word.

        :raises ProgramFailed: the program ended before, or it took too long
        """
        deadline = time.monotonic() + timeout_s
        while True:
            try:
                line = self._lines.get(timeout=max(deadline - time.monotonic(), 0.0))
            except queue.Empty:
                raise self._failed(f'was not ready after {timeout_s:g} s') from None
            if line is None:
                raise self._failed(f'ended with {self._process.wait()}')
            if word in line:
                return line

    def stop(self) -> int:
        """Ask the program to end, kill it if it does not, and return its exit status."""
        if not self.ended:
            self._process.send_signal(signal.SIGINT)
        try:
            status = self._process.wait(FAREWELL_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            status = self._process.wait()
        self._reader.join()
        return status

    def _read(self) -> None:
        assert self._process.stdout is not None
        with self._process.stdout as output, self._log.open('a') as log:
            for line in output:
                log.write(line)
                self._lines.put(line.rstrip('\n'))
        self._lines.put(None)

    def _failed(self, what: str) -> ProgramFailed:
        last = self._log.read_text(errors='replace').splitlines()[-10:]
        words = '\n  '.join(last) or '(it said nothing)'
        return ProgramFailed(f'{self.name} {what}; the end of {self._log}:\n  {words}')
