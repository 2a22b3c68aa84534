"""SIGINT and SIGTERM end a program of the tests as Ctrl-C does, also in the background."""

from __future__ import annotations

import signal


def heed() -> None:
    """Let this program, and those that it starts, be ended with everything that they started.

    A shell lets what it starts in the background ignore SIGINT, and so do all programs below it
    until they say otherwise: a program that is stopped before that would never end. SIGTERM ends
    Python at once: processes in sessions of their own, as `ProgramProcess` has them, would stay.
    """
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    if signal.getsignal(signal.SIGTERM) is signal.SIG_DFL:
        signal.signal(signal.SIGTERM, signal.default_int_handler)
