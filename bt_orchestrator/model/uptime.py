"""How much time has passed, by a clock that nobody sets (semantics 9.2).

The wall clock is set, by people and by NTP, and that of another machine is another one.
"""

from __future__ import annotations

from typing import NamedTuple


class Uptime(NamedTuple):
    """A moment on the clock that begins with the boot of a machine and is never set."""

    boot: str
    """Which boot of which machine."""
    seconds: float


def seconds_between(earlier: Uptime | None, later: Uptime | None) -> float | None:
    """Return how much time passed between two moments; None: that cannot be known."""
    if earlier is None or later is None or earlier.boot != later.boot:
        return None
    return later.seconds - earlier.seconds
