"""Keys of the person at a terminal, and waiting for one of them or for a stop signal."""

from __future__ import annotations

import os
import pty
import signal
import sys
import termios
import threading
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest

from bt_orchestrator.base.stop_signals import StopSignals
from bt_orchestrator.cli.reporting.following import StopOrKey
from bt_orchestrator.view.screen.keys import keys_of_person

LONG_S = 30.0


@contextmanager
def a_terminal(monkeypatch: pytest.MonkeyPatch) -> Iterator[int]:
    """Make a terminal the standard input; yield the end at which the person types."""
    person, program = pty.openpty()
    with closing(os.fdopen(program)) as terminal:
        monkeypatch.setattr(sys, 'stdin', terminal)
        yield person
    os.close(person)


def test_terminal_is_restored_after_reading_keys(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A terminal that shows what is typed, and waits for a line, does so again."""
    with a_terminal(monkeypatch) as person:
        before = termios.tcgetattr(sys.stdin)
        with keys_of_person() as keys, StopSignals() as stop, StopOrKey(stop, keys) as waiting:
            assert keys is not None
            assert keys.pressed() == ''
            os.write(person, b'1')
            assert not waiting.ends_within(LONG_S)
            os.write(person, b'q')
            assert waiting.ends_within(LONG_S)
        assert termios.tcgetattr(sys.stdin) == before


def test_there_are_no_keys_without_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    """A pipe or a closed input has no person."""
    with Path(os.devnull).open() as nothing:
        monkeypatch.setattr(sys, 'stdin', nothing)
        with keys_of_person() as keys:
            assert keys is None


def test_a_stop_signal_ends_the_wait_at_once() -> None:
    """Also where nobody can press a key."""
    with StopSignals() as stop, StopOrKey(stop, None) as waiting:
        threading.Timer(0.05, os.kill, (os.getpid(), signal.SIGINT)).start()
        assert waiting.ends_within(LONG_S)
        assert stop.requested
