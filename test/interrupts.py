"""SIGINT as a person's Ctrl-C, also where the tests themselves run in the background."""

from __future__ import annotations

import signal


def heed() -> None:
    """Let programs that are started from here be interrupted.

    A shell lets what it starts in the background ignore SIGINT, and so do all programs below it
    until they say otherwise: a program that is stopped before that would never end.
    """
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
