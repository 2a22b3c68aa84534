"""Seconds as messages, and back."""

from __future__ import annotations

from builtin_interfaces.msg import Time

_NS = 1_000_000_000


def to_time(seconds: float) -> Time:
    """Return seconds since the epoch as a message, to the nanosecond."""
    # Apart: nanoseconds since the epoch are more than the digits of a float.
    whole, part = divmod(seconds, 1.0)
    carried, rest = divmod(round(part * _NS), _NS)
    return Time(sec=int(whole) + carried, nanosec=rest)


def from_time(time: Time) -> float:
    """Return the seconds since the epoch of a message."""
    return float(time.sec + time.nanosec / _NS)


def to_moment(seconds: float | None) -> Time:
    """Return a time that may be absent; then it is zero."""
    return Time() if seconds is None else to_time(seconds)


def from_moment(time: Time) -> float | None:
    """Return the seconds since the epoch of a message; None: it is zero, there is no time."""
    return from_time(time) or None
