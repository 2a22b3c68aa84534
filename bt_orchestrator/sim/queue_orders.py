"""Orders that the queue could have, the most promising ones first (semantics 6.7).

What an order leads to is only guessed here: jobs one after the other, each for as long as it took
in a run. The guess decides which orders the engine looks at first, and nothing else.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from heapq import nsmallest
from itertools import permutations, product
from typing import NamedTuple

Order = tuple[int, ...]
"""Jobs by their present places, from 0, in another order."""

FEW = 720
"""Up to so many orders are all looked at."""

GUESSES = 10_000
"""Most orders of a longer queue that are guessed."""

KEPT = 500
"""Most of them that are returned, the most promising ones."""


class Waiting(NamedTuple):
    """A job of the queue."""

    priority: int
    is_free: bool
    """Whether it may get another place."""
    due_s: float
    """When it should have ended; infinite: not said."""
    start_s: float = -math.inf
    """Before that it does not start."""
    work_s: float = 0.0
    """How long it keeps the line."""


class QueueOrders:
    """The orders of a queue in which jobs of a higher priority come first, in free places."""

    def __init__(self, jobs: Sequence[Waiting], begins_s: float = 0.0) -> None:
        """Begin.

        :param begins_s: when the line has room for the first one
        """
        self._jobs = jobs
        self._begins_s = begins_s
        self._any_waits = any(job.start_s > begins_s for job in jobs)
        self._places = [at for at, job in enumerate(jobs) if job.is_free]
        alike: Mapping[int, list[int]] = defaultdict(list)
        for at in self._places:
            alike[jobs[at].priority].append(at)
        self._alike = [alike[priority] for priority in sorted(alike, reverse=True)]
        """Free jobs of one priority, the highest first."""
        self._guesses: dict[Order, tuple[int, int, Order]] = {}

    @property
    def count(self) -> int:
        """How many orders there are."""
        return math.prod(math.factorial(len(jobs)) for jobs in self._alike)

    def promising(self) -> list[Order]:
        """Return orders, the most promising first; of few, all."""
        if self.count <= FEW:
            for parts in product(*map(permutations, self._alike)):
                self._guess(self._whole(sum(parts, ())))
        else:
            _, _, free = min((*self._guess(self._whole(one))[:2], one) for one in self._begins())
            self._improve(free)
            self._look_around()
        best = nsmallest(KEPT if self.count > FEW else FEW, self._guesses.values())
        return [order for _, _, order in best]

    def change(self, order: Order) -> int:
        """Return by how many places all jobs together are moved."""
        return sum(abs(at - job) for at, job in enumerate(order))

    def _whole(self, free: Sequence[int]) -> Order:
        """Return an order with the free jobs in this one, and all others where they are."""
        order = list(range(len(self._jobs)))
        for at, job in zip(self._places, free, strict=True):
            order[at] = job
        return tuple(order)

    def _free(self, order: Order) -> list[int]:
        return [order[at] for at in self._places]

    def _begins(self) -> Iterator[list[int]]:
        """Yield orders of the free jobs to begin with: as now, and by when they are due."""
        jobs = self._jobs
        yield [at for alike in self._alike for at in alike]
        yield [at for alike in self._alike for at in sorted(alike, key=lambda at: jobs[at].due_s)]
        found, now_s = [], self._begins_s
        for alike in self._alike:
            left = list(alike)
            while left:  # what is due before it could be ready is judged by its length
                soonest = min(left, key=lambda at: max(jobs[at].due_s, now_s + jobs[at].work_s))
                left.remove(soonest)
                found.append(soonest)
                now_s += jobs[soonest].work_s
        yield found

    def _improve(self, free: list[int]) -> None:
        """Move one job after the other to where it does best, as long as that helps."""
        best, is_better = self._guess(self._whole(free)), True
        while is_better:
            is_better = False
            for at, to in self._moves():
                if len(self._guesses) >= GUESSES:
                    return
                other = free[:]
                other.insert(to, other.pop(at))
                guess = self._guess(self._whole(other))
                if guess < best:
                    free, best, is_better = other, guess, True

    def _look_around(self) -> None:
        """Move one job in the best orders, one after the other, also where it does not help."""
        seen = set[Order]()
        while left := self._guesses.keys() - seen:
            order = min(left, key=self._guesses.__getitem__)
            seen.add(order)
            for at, to in self._moves():
                if len(self._guesses) >= GUESSES:
                    return
                free = self._free(order)
                free.insert(to, free.pop(at))
                self._guess(self._whole(free))

    def _moves(self) -> Iterator[tuple[int, int]]:
        """Yield places among the free jobs, of one priority: from where, to where."""
        begin = 0
        for alike in self._alike:
            yield from permutations(range(begin, begin + len(alike)), 2)
            begin += len(alike)

    def _guess(self, order: Order) -> tuple[int, int, Order]:
        """Return how bad an order is: milliseconds too late, and change; note it."""
        known = self._guesses.get(order)
        if known is None:
            guess = (self._late_ms(order), self.change(order), order)
            known = self._guesses[order] = guess
        return known

    def _late_ms(self, order: Order) -> int:
        now_s, late_ms = self._begins_s, 0
        waiting = [self._jobs[at] for at in order]
        if not self._any_waits:
            for job in waiting:
                now_s += job.work_s
                late_ms += too_late_ms(now_s, job.due_s)
            return late_ms
        while waiting:
            soonest = min(waiting, key=lambda one: one.start_s)
            job = next((one for one in waiting if one.start_s <= now_s), soonest)
            waiting.remove(job)
            now_s = max(now_s, job.start_s) + job.work_s
            late_ms += too_late_ms(now_s, job.due_s)
        return late_ms


def too_late_ms(ends_s: float, due_s: float) -> int:
    """Return by how much an end is too late, in whole milliseconds."""
    return max(0, round((ends_s - due_s) * 1000)) if due_s < math.inf else 0
