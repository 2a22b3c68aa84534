"""SIGINT and SIGTERM end a program of the tests as Ctrl-C does, also in the background."""

from __future__ import annotations

import atexit
import os
import signal
from contextlib import suppress

from process_use import family


def heed() -> None:
    """Let this program, and those that it starts, be ended with everything that they started.

    A shell lets what it starts in the background ignore SIGINT, and so do all programs below it
    until they say otherwise: a program that is stopped before that would never end. SIGTERM ends
    Python at once: processes in sessions of their own, as `ProgramProcess` has them, would stay.
    So would one that nobody has yet when the signal comes; it goes when this one ends.
    """
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    if signal.getsignal(signal.SIGTERM) is signal.SIG_DFL:
        signal.signal(signal.SIGTERM, signal.default_int_handler)
    atexit.register(_leave_no_process)


def _leave_no_process() -> None:
    own = os.getpid()
    for _ in range(100):
        with suppress(OSError):  # one that has ended meanwhile
            others = family(own) - {own}
            if not others:
                return
            for pid in others:
                os.kill(pid, signal.SIGKILL)
            os.waitpid(-1, 0)
