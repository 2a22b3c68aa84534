"""Changes that make a line faster until something else limits it: a task, a roomier flag."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import ceil

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.proof.pace import Limit, PacedLine
from bt_orchestrator.model.script import INDEX


@dataclass(frozen=True)
class Quicker:
    """The gain from a faster task."""

    task: str
    """The longest task of the limit."""
    takes_s: float
    """Its present time."""
    by_s: float
    """The least saving that makes something else the limit; more saves nothing.

    0: something else takes as long anyway."""
    then: Limit
    """The limit of the line then."""

    def __str__(self) -> str:
        if not round(self.by_s, 1):
            take = 'take' if len(self.then.tasks) > 1 else 'takes'
            no_help = f'Speeding up {self.task} alone does not help'
            return f'{no_help}: {self.then} {take} as long.'
        by = f'Without {self.task}'
        if self.by_s < self.takes_s:
            by = f'With {self.task} {self.by_s:.1f} s faster'
        return f'{by} {_would_be(self.then)}'


def _would_be(limit: Limit) -> str:
    return f'the pace would be {limit.per_item_s:.1f} s per item, limited by {limit}.'


def quicker(line: PacedLine, cell: Cell) -> Quicker | None:
    """Return the gain from making the longest task of the limit faster; None: there is none.

    A task that is in several circles may have to save more for another one than for the slowest.
    """
    if line.gets_stuck:
        return None
    us = line.durations(cell)
    limit = line.limit(us)
    task = max((name for name in limit.tasks if name != INDEX), key=us.__getitem__, default=None)
    if task is None:
        return None
    then = line.limit({**us, task: 0})
    saved = 0
    while limit.per_item_us > then.per_item_us:
        too_long = (limit.per_item_us - then.per_item_us) * limit.items
        saved += ceil(too_long / limit.tasks.count(task))
        limit = line.limit({**us, task: us[task] - saved})
    return Quicker(task, us[task] / 1_000_000, saved / 1_000_000, then)


FLAGS_TRIED = 4
"""In a circle of more flags a larger capacity of one brings little."""


@dataclass(frozen=True)
class Roomier:
    """The gain from a larger capacity of a flag, where it is no more than a number."""

    flag: str
    capacity: int
    then: Limit
    """The limit of the line then."""

    def __str__(self) -> str:
        return f'With capacity {self.capacity} of flag {self.flag} {_would_be(self.then)}'


def roomier(line: PacedLine, cell: Cell) -> Roomier | None:
    """Return the flag of the limit that gains most from one count more of capacity; None: none."""
    if line.gets_stuck:
        return None
    us = line.durations(cell)
    limit = line.limit(us)
    flags = [line.flags[name] for name in limit.flags] if len(limit.flags) <= FLAGS_TRIED else []
    larger = [replace(flag, capacity=flag.capacity + 1) for flag in flags]
    tried = [Roomier(flag.flag, flag.capacity, line.limit(us, flag)) for flag in larger]
    best = min(tried, key=lambda trial: trial.then.per_item_us, default=None)
    return best if best is not None and best.then.per_item_us < limit.per_item_us else None
