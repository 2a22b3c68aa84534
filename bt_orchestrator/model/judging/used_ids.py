"""Which order ids, or serials, were ever used: a set that stays small when they are counted up."""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass, field

_COUNTED = re.compile(r'(?s)(.*?)(0|[1-9][0-9]{0,17})')
"""An id as a prefix and a number without leading zeros: `WO-007` is `WO-00` and 7."""


@dataclass
class UsedIds:
    """A set of ids that only grows.

    Numbers behind one prefix are kept as runs, so WO-1 to WO-100000 are two numbers and not a
    hundred thousand texts. An id that ends in no number is kept as it is.
    """

    others: set[str] = field(default_factory=set)
    runs: dict[str, list[list[int]]] = field(default_factory=dict)
    """By prefix: first and last number of each run, ascending, with gaps between them."""

    def __contains__(self, name: str) -> bool:
        counted = _COUNTED.fullmatch(name)
        if counted is None:
            return name in self.others
        runs, number = self.runs.get(counted[1], []), int(counted[2])
        at = _run_at(runs, number)
        return at >= 0 and number <= runs[at][1]

    def add(self, name: str) -> None:
        """Take an id in."""
        counted = _COUNTED.fullmatch(name)
        if counted is None:
            self.others.add(name)
        elif name not in self:
            _add(self.runs.setdefault(counted[1], []), int(counted[2]))

    def free(self, prefix: str) -> Iterator[str]:
        """Yield the ids of a prefix and a number from 1 that were never used, ascending."""
        number, runs = 1, self.runs.get(prefix, [])
        while True:
            at = _run_at(runs, number)
            number = max(number, runs[at][1] + 1) if at >= 0 else number
            yield f'{prefix}{number}'
            number += 1


def _run_at(runs: list[list[int]], number: int) -> int:
    """Return the place of the last run that begins at a number or before; -1: none does."""
    return bisect_right(runs, number, key=lambda run: run[0]) - 1


def _add(runs: list[list[int]], number: int) -> None:
    """Put a number that is in no run into one, or between two."""
    at = _run_at(runs, number)
    follows = at >= 0 and runs[at][1] == number - 1
    precedes = at + 1 < len(runs) and runs[at + 1][0] == number + 1
    if follows and precedes:
        runs[at][1] = runs.pop(at + 1)[1]
    elif follows:
        runs[at][1] = number
    elif precedes:
        runs[at + 1][0] = number
    else:
        runs.insert(at + 1, [number, number])
