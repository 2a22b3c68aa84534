"""Demands that contradict each other; without any one of them there is no contradiction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Demand:
    """A set of sections for one piece, or an order of two."""

    words: str
    first: int
    second: int = -1
    """Is done in no section before the first one; -1: the demand is about one piece."""
    sections: tuple[int, ...] = ()
    """Of the one piece."""
    room: tuple[tuple[int, int], ...] = ()
    """By section of the first piece, the last section of the second."""


def irreducible(demands: Sequence[Demand], pieces: int, sections: int) -> list[Demand]:
    """Return demands that no line meets; without any one of them there is one that does.

    :param demands: that no line meets together
    :param sections: of the belt
    """
    needed = list(demands)
    for one in demands:
        others = [other for other in needed if other is not one]
        if not all(narrowed(others, pieces, sections)):
            needed = others
    return needed


def narrowed(demands: Sequence[Demand], pieces: int, sections: int) -> list[set[int]]:
    """Return the sections of each piece that fit to others; of some there is none if none do."""
    left = [set(range(1, sections + 1)) for _ in range(pieces)]
    for one in demands:
        if one.second < 0:
            left[one.first] &= {*one.sections}
    pairs = [one for one in demands if one.second >= 0]
    before = 0
    while all(left) and before != (before := sum(map(len, left))):
        for one in pairs:
            first, second = left[one.first], left[one.second]
            last = dict(one.room)
            fits = {
                here: {there for there in second if here <= there <= last.get(here, sections)}
                for here in first
            }
            left[one.first] = {here for here in first if fits[here]}
            left[one.second] = set().union(*fits.values())
    return left
