"""Elapsed time by a clock that is never set (semantics 9.2).

The wall clock may be set, by people and by NTP, and differs between machines.
"""

from __future__ import annotations

from typing import NamedTuple


class Uptime(NamedTuple):
    """A moment on the clock that begins with the boot of a machine and is never set."""

    boot: str
    """The boot of the machine."""
    seconds: float


class ClockReading(NamedTuple):
    """A moment on two clocks."""

    wall: float
    """Seconds of the wall clock."""
    up: Uptime


def step_between(earlier: ClockReading | None, wall: float, up: Uptime | None) -> float:
    """Return by how many seconds the wall clock was set since a reading; 0.0: not known, or not.

    :param wall: the wall clock at the later moment
    :param up: the uptime at the same moment
    """
    passed_s = seconds_between(earlier.up, up) if earlier is not None else None
    return 0.0 if earlier is None or passed_s is None else wall - earlier.wall - passed_s


def seconds_between(earlier: Uptime | None, later: Uptime | None) -> float | None:
    """Return the time between two moments; None: unknown."""
    if earlier is None or later is None or earlier.boot != later.boot:
        return None
    return later.seconds - earlier.seconds
