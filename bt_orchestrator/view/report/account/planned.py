"""Planned time: the stretches of a period in which the cell was meant to work."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

US = 1_000_000

Stretch = tuple[int, int]
"""From when to when, in microseconds since the epoch."""


def us_of(time: float) -> int:
    """Return a time of an event in whole microseconds, for exact sums."""
    return round(time * US)


@dataclass(frozen=True)
class Planned:
    """Stretches of time in order, none touching another; in microseconds since the epoch."""

    pieces: tuple[Stretch, ...]

    @classmethod
    def of(cls, pieces: Iterable[Stretch], breaks: Sequence[Stretch] = ()) -> Planned:
        """Return the time of some stretches, which may overlap, without the breaks in them."""
        joined: list[Stretch] = []
        for begin, end in sorted(pieces):
            if joined and begin <= joined[-1][1]:
                joined[-1] = joined[-1][0], max(joined[-1][1], end)
            elif begin < end:
                joined.append((begin, end))
        for off, on in breaks:
            joined = [
                part
                for begin, end in joined
                for part in ((begin, min(end, off)), (max(begin, on), end))
                if part[0] < part[1]
            ]
        return cls(tuple(joined))

    @property
    def total_us(self) -> int:
        """All of it."""
        return sum(end - begin for begin, end in self.pieces)

    def before(self, end: int) -> Planned:
        """Return what of it lies before a moment."""
        return Planned.of((begin, min(there, end)) for begin, there in self.pieces)

    def between(self, begin: int, end: int) -> int:
        """Return how much of it lies between two moments."""
        return sum(
            max(0, min(end, there) - max(begin, here))
            for here, there in self.pieces[self._first(begin) :]
            if here < end
        )

    def includes(self, moment: int) -> bool:
        """Tell whether what ended at a moment was done in planned time.

        What ends with a stretch belongs to it, and not to the next one, which begins there.
        """
        at = self._first(moment - 1)
        return at < len(self.pieces) and self.pieces[at][0] < moment

    def _first(self, moment: int) -> int:
        """Return the number of the first stretch that ends after a moment."""
        return bisect_left(self.pieces, moment + 1, key=lambda piece: piece[1])
