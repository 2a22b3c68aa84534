"""Spans of time, and how long they last together."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple


class Span(NamedTuple):
    """From when to when something ran, in seconds."""

    start: float
    end: float


def covered_s(spans: Iterable[Span]) -> float:
    """Return the seconds in which at least one span runs; what overlaps counts once."""
    total = 0.0
    until = float('-inf')
    for start, end in sorted(spans):
        total += max(0.0, end - max(start, until))
        until = max(until, end)
    return total
