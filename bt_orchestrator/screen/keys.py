"""Single keys of a person at a terminal, without a line end."""

from __future__ import annotations

import os
import select
import sys
import termios
import tty
from types import TracebackType


def keyboard() -> int | None:
    """Return the descriptor of the standard input, if a person can press keys there.

    A program in the background of its terminal would be stopped by reading from it.
    """
    try:
        descriptor = sys.stdin.fileno()
    except (AttributeError, OSError, ValueError):  # no input, or a closed one
        return None
    return descriptor if os.isatty(descriptor) and not _is_in_background(descriptor) else None


def _is_in_background(descriptor: int) -> bool:
    try:
        return os.tcgetpgrp(descriptor) != os.getpgrp()
    except OSError:  # a terminal that controls no programs
        return False


class Keys:
    """A context: inside, keys come at once and are not shown. Ctrl-C stays what it is."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor

    def __enter__(self) -> Keys:
        self._before = termios.tcgetattr(self._descriptor)
        tty.setcbreak(self._descriptor)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        termios.tcsetattr(self._descriptor, termios.TCSADRAIN, self._before)

    def pressed(self) -> str:
        """Return the keys that were pressed since the last call; empty: none."""
        if not select.select([self._descriptor], [], [], 0.0)[0]:
            return ''
        try:
            return os.read(self._descriptor, 64).decode(errors='ignore')
        except OSError:  # the terminal has gone
            return ''
