"""A program on a pseudo-terminal, and what a person would see there, for tests."""

from __future__ import annotations

import fcntl
import os
import pty
import select
import signal
import struct
import subprocess
import sys
import termios
import time
from collections.abc import Callable, Mapping, Sequence

import pyte
from patience import PATIENCE_S


class PseudoTerminal:
    """One verb of the program on a terminal of its own. Everything runs in its caller.

    :ivar raw: every byte that was sent to the terminal
    """

    def __init__(
        self,
        words: Sequence[str],
        columns: int = 80,
        lines: int = 24,
        environment: Mapping[str, str] | None = None,
    ) -> None:
        """Start it; `words` is a command line from the verb on."""
        self._screen = pyte.Screen(columns, lines)
        self._stream = pyte.ByteStream(self._screen)
        self._master, slave = pty.openpty()
        self._set_size(slave)
        self.modes = termios.tcgetattr(slave)
        unsized = {k: v for k, v in os.environ.items() if k not in ('COLUMNS', 'LINES')}
        self._process = subprocess.Popen(
            [sys.executable, '-m', 'bt_orchestrator', *words],
            stdin=slave,
            stdout=slave,
            stderr=slave,
            env={**unsized, 'TERM': 'xterm-256color', **(environment or {})},
            start_new_session=True,
        )
        self._slave = slave
        self.raw = b''

    @property
    def pid(self) -> int:
        """Process id of the program."""
        return self._process.pid

    def read_for(self, seconds: float) -> None:
        """Take what it shows, for so long."""
        until = time.monotonic() + seconds
        while (left_s := until - time.monotonic()) > 0:
            self._read(left_s)

    @property
    def lines(self) -> list[str]:
        """What can be read, from top to bottom."""
        return [line.rstrip() for line in self._screen.display]

    @property
    def text(self) -> str:
        """What can be read, as one text."""
        return '\n'.join(self.lines).rstrip()

    def until(
        self, is_so: Callable[[str], object], what: str, within_s: float = PATIENCE_S
    ) -> None:
        """Wait until something is so of the text."""
        deadline = time.monotonic() + within_s
        while not is_so(self.text):
            assert time.monotonic() < deadline, f'waited for {what}; it shows:\n{self.text}'
            self._read(0.1)

    def until_shows(self, words: str) -> None:
        """Wait until some words can be read."""
        self.until(lambda text: words in text, words)

    def resize(self, columns: int, lines: int) -> None:
        """Change the size, as a person does by pulling at the window."""
        self._screen.resize(lines, columns)
        self._set_size(self._slave)
        self._process.send_signal(signal.SIGWINCH)

    def press(self, keys: str) -> None:
        """Press keys, as a person does."""
        os.write(self._master, keys.encode())

    def send(self, with_signal: signal.Signals) -> None:
        """Send the program a signal."""
        self._process.send_signal(with_signal)

    def wait(self) -> int:
        """Return its exit status, with all that it said before."""
        deadline = time.monotonic() + PATIENCE_S
        while self._process.poll() is None:
            assert time.monotonic() < deadline, f'did not end; it shows:\n{self.text}'
            self._read(0.1)
        while self._read(0.1):
            pass
        return self._process.returncode

    def assert_left_clean(self) -> None:
        """Fail unless the terminal is as it was: first screen, cursor, echo."""
        assert self.raw.count(b'\x1b[?1049h') == self.raw.count(b'\x1b[?1049l')
        assert self.raw.rfind(b'\x1b[?25h') > self.raw.rfind(b'\x1b[?25l'), 'the cursor is hidden'
        assert termios.tcgetattr(self._slave) == self.modes
        assert b'Traceback' not in self.raw, self.raw.decode(errors='replace')

    def close(self) -> None:
        """Leave nothing behind, whatever happened."""
        self._process.kill()
        self._process.wait()
        os.close(self._slave)
        os.close(self._master)

    def _read(self, within_s: float) -> bool:
        if not select.select([self._master], [], [], within_s)[0]:
            return False
        data = os.read(self._master, 65536)
        self.raw += data
        self._stream.feed(data)
        return True

    def _set_size(self, descriptor: int) -> None:
        size = struct.pack('HHHH', self._screen.lines, self._screen.columns, 0, 0)
        fcntl.ioctl(descriptor, termios.TIOCSWINSZ, size)
