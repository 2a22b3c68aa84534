"""Elapsed time by a clock that is never set (semantics 9.2).

The wall clock may be set, by people and by NTP, and differs between machines.
"""

from __future__ import annotations

from typing import NamedTuple


class Uptime(NamedTuple):
    """A moment on the clock that begins with the boot of a machine and is never set."""

    boot: str
    """Which boot of which machine."""
    seconds: float


def seconds_between(earlier: Uptime | None, later: Uptime | None) -> float | None:
    """Return the time between two moments; None: unknown."""
    if earlier is None or later is None or earlier.boot != later.boot:
        return None
    return later.seconds - earlier.seconds
