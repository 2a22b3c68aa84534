"""Spans of time: how much time they cover, and where they overlap."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
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


def common(some: Iterable[Span], others: Iterable[Span]) -> Iterator[Span]:
    """Yield the parts of some spans that lie within others; those do not overlap each other."""
    within = sorted(others)
    for span in some:
        for other in within:
            start, end = max(span.start, other.start), min(span.end, other.end)
            if start < end:
                yield Span(start, end)


def gaps(whole: Span, spans: Iterable[Span]) -> Iterator[Span]:
    """Yield the parts of a span in which no other runs."""
    until = whole.start
    for start, end in sorted(spans):
        if until < min(start, whole.end):
            yield Span(until, min(start, whole.end))
        until = max(until, end)
    if until < whole.end:
        yield Span(until, whole.end)
