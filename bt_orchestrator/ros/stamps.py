"""Seconds as messages."""

from __future__ import annotations

from builtin_interfaces.msg import Time

_NS = 1_000_000_000


def to_time(seconds: float) -> Time:
    """Return seconds since the epoch as a message."""
    whole, rest = divmod(round(seconds * _NS), _NS)
    return Time(sec=int(whole), nanosec=int(rest))


def to_moment(seconds: float | None) -> Time:
    """Return a time that may be absent; then it is zero."""
    return Time() if seconds is None else to_time(seconds)
