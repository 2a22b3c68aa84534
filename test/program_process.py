"""One verb of the program in a process of its own, for tests."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from loaded_program import LoadedProcess, LoadedProgram
from patience import PATIENCE_S

from bt_orchestrator.cli.verbs import PROGRAM as NAME

_LOOK_S = 0.02

DEMO_PACKED = (
    r'job +script +items +packed +per item +finished\s+WO-1001 +reference_process( +3){2} '
)
"""How the demo sums up three items, all of them packed and good: no column of losses."""

PROGRAM = ('-m', 'bt_orchestrator')
"""What Python runs."""

loaded: LoadedProgram | None = None
"""Starts the program where it is set, as in a run of tests; None: Python does."""


class ProgramProcess:
    """States: starting, ready (after `wait_ready`), ended (after `stop` or `wait`).

    What it prints goes to files, so that it never waits for a reader.
    """

    def __init__(
        self,
        words: Sequence[str],
        folder: Path,
        name: str,
        program: Sequence[str] = PROGRAM,
        within: Sequence[str] = (),
        cwd: Path | None = None,
    ) -> None:
        """Start it; `words` is a command line from the verb on.

        :param folder: for what it prints
        :param program: what Python runs, if not the program itself
        :param within: a command that becomes the program, such as `ip netns exec NAME`
        :param cwd: its working directory, if not `folder`: here `-m` would find the source tree
        """
        self._output = folder / f'{name}.out'
        self._errors = folder / f'{name}.err'
        cwd = cwd or folder
        env = os.environ | {
            'ROS_LOG_DIR': str(folder / 'ros_log'),
            'XDG_STATE_HOME': str(folder),
        }
        self._process: subprocess.Popen[bytes] | LoadedProcess
        with self._output.open('wb') as output, self._errors.open('wb') as errors:
            if loaded is not None and program is PROGRAM and not within:
                self._process = loaded.start(words, output, errors, cwd, env)
                return
            self._process = subprocess.Popen(
                [*within, sys.executable, '-u', *program, *words],
                cwd=cwd,
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=errors,
                env=env,
                start_new_session=True,
            )

    @property
    def pid(self) -> int:
        """Process id, also of its process group."""
        return self._process.pid

    @property
    def output(self) -> str:
        """What it has printed so far."""
        return self._output.read_text()

    @property
    def errors(self) -> str:
        """What it has printed on stderr so far."""
        return self._errors.read_text()

    @property
    def is_running(self) -> bool:
        """Tell whether it has not ended."""
        return self._process.poll() is None

    def wait_ready_or_end(self) -> None:
        """Wait until it is ready, or has ended, which may be what it was started for."""
        while self._look() is None and 'ready: ' not in self.output:
            pass

    def wait_ready(self, words: str = 'ready: ') -> str:
        """Return the first line that holds these words; fails if it ends before.

        Whoever gives up meanwhile, or is interrupted, has no process: what is just starting may
        miss a signal that asks it to end.
        """
        try:
            return self._wait_for(words)
        except BaseException:
            self.kill()
            raise

    def _wait_for(self, words: str) -> str:
        deadline = time.monotonic() + PATIENCE_S
        while True:
            lines = self.output.splitlines(keepends=True)
            hit = next((line for line in lines if words in line and line.endswith('\n')), None)
            if hit is not None:
                return hit.rstrip()
            status = self._look()
            assert status is None, f'ended with {status} before {words!r}: {self.errors}'
            assert time.monotonic() < deadline, f'never said {words!r}: {self.output}'

    def send(self, with_signal: signal.Signals) -> None:
        """Send it a signal."""
        self._process.send_signal(with_signal)

    def wait(self, within_s: float = PATIENCE_S) -> int:
        """Return its exit status; fails, and kills it, if it does not end in time."""
        try:
            return self._process.wait(within_s)
        except subprocess.TimeoutExpired:
            self.kill()
            raise AssertionError(f'did not end within {within_s:g} s: {self.errors}') from None

    def stop(self, with_signal: signal.Signals = signal.SIGINT) -> int:
        """Ask it to end, and return its exit status; harmless if it has ended."""
        if self._process.poll() is None:
            self.send(with_signal)
        return self.wait()

    def kill(self) -> None:
        """End it without a word to anybody; harmless if it has ended."""
        self._process.kill()
        self._process.wait()

    def assert_clean(self) -> None:
        """Fail if anything went wrong inside, whatever the exit status says."""
        for word in ('Traceback', '[ERROR]', '[FATAL]'):
            assert word not in self.errors, self.errors

    def _look(self) -> int | None:
        try:
            return self._process.wait(_LOOK_S)
        except subprocess.TimeoutExpired:
            return None


def program_in(folder: Path) -> Path:
    """Put the program of this very environment into a new folder for PATH."""
    folder.mkdir()
    program = folder / NAME
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m bt_orchestrator "$@"\n')
    program.chmod(0o755)
    return folder
