"""Single keys of the person at a terminal, without a line end."""

from __future__ import annotations

import os
import select
import socket
import sys
import termios
import tty
from collections.abc import Iterator
from contextlib import contextmanager

from bt_orchestrator.stop_signals import StopSignals


class Keys:
    """What the person presses; see `keys_of_person`."""

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


class StopOrKey:
    """A context: waits for a stop signal, or for a key of the person, if there is one."""

    def __init__(self, stop: StopSignals, keys: Keys | None) -> None:
        self._stop = stop
        self._keys = keys

    def __enter__(self) -> StopOrKey:
        self._woken, self._wake = socket.socketpair()
        self._stop.notify(lambda: self._wake.send(b'.'))
        return self

    def __exit__(self, *exception: object) -> None:
        self._stop.notify(lambda: None)
        self._wake.close()
        self._woken.close()

    def ends_within(self, limit_s: float) -> bool:
        """Wait so long, or until a key is pressed; return whether the person wants an end."""
        inputs: list[socket.socket | Keys] = [self._woken]
        if self._keys is not None:
            inputs.append(self._keys)
        select.select(inputs, [], [], limit_s)
        keys = '' if self._keys is None else self._keys.pressed()
        return self._stop.requested or 'q' in keys


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
