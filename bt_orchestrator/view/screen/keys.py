"""The keys of a person at a terminal, and its second screen."""

from __future__ import annotations

import os
import select
import sys
import termios
import tty
from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console, ConsoleDimensions, RenderableType
from rich.live import Live


class SecondScreen:
    """The screen while it is taken; see `second_screen`."""

    def __init__(self, console: Console, live: Live) -> None:
        self._console = console
        self._live = live

    @property
    def size(self) -> ConsoleDimensions:
        """Columns and lines of the present terminal."""
        return self._console.size

    def show(self, picture: RenderableType) -> None:
        """Draw a picture in place of the one before."""
        self._live.update(picture, refresh=True)


@contextmanager
def second_screen() -> Iterator[SecondScreen | None]:
    """Take the second screen of the terminal, and give the first one back at the end.

    None: the standard output is no terminal on which a picture can be drawn.
    """
    console = Console()
    if console.is_dumb_terminal or not console.is_terminal:
        yield None
        return
    live = Live(console=console, screen=True, auto_refresh=False, redirect_stdout=False)
    with live:
        yield SecondScreen(console, live)


class Keys:
    """The keys that a person presses; see `keys_of_person`."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor

    def fileno(self) -> int:
        """Return what `select` waits for."""
        return self._descriptor

    def pressed(self) -> str:
        """Return the keys that were pressed since the last call; empty: none."""
        if not select.select([self], [], [], 0.0)[0]:
            return ''
        try:
            return os.read(self._descriptor, 64).decode(errors='ignore')
        except OSError:  # the terminal has gone
            return ''


@contextmanager
def keys_of_person() -> Iterator[Keys | None]:
    """Open the keyboard: inside, keys come at once and are not shown. Ctrl-C stays what it is.

    None: the standard input is no terminal at which a person can press keys.
    """
    descriptor = _keyboard()
    if descriptor is None:
        yield None
        return
    before = termios.tcgetattr(descriptor)
    tty.setcbreak(descriptor)
    try:
        yield Keys(descriptor)
    finally:
        termios.tcsetattr(descriptor, termios.TCSADRAIN, before)


def _keyboard() -> int | None:
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
