"""Instants, and callbacks in order of their deadlines: the heap under every clock."""

from __future__ import annotations

import heapq
from collections.abc import Callable

Callback = Callable[[], None]

NS_PER_S = 1_000_000_000

_FEW = 64
"""With at most so many cancelled deadlines, there is no clean-up."""


def instant_ns(time_s: float) -> int:
    """Convert a time in seconds to integer nanoseconds.

    A sum of seconds may differ from the clock's time by a rounding error; as nanoseconds both are
    equal. Clocks call back at this instant, so `has_come` is true then.
    """
    return round(time_s * NS_PER_S)


def has_come(due_s: float, now_s: float) -> bool:
    """Tell whether a time has come, with the same rounding as the clock's callbacks."""
    return instant_ns(due_s) <= instant_ns(now_s)


class Deadline:
    """One callback that waits for its time. Implements `ports.Timer`."""

    __slots__ = ('_owner', 'callback', 'time_ns')

    def __init__(self, time_ns: int, callback: Callback, owner: Deadlines) -> None:
        self.time_ns = time_ns
        self.callback: Callback | None = callback
        self._owner = owner

    def cancel(self) -> None:
        """Forget the callback; harmless when it was called already."""
        if self.callback is not None:
            self.callback = None
            self._owner.forget_one()


class Deadlines:
    """Deadlines in order of time; equal times in the order they were added.

    Times are integer nanoseconds, so that 1.5 s + 1.0 s and 2.5 s are the same instant.
    Cancelled ones are dropped when they reach the top or when they are more than half.
    """

    def __init__(self) -> None:
        self._heap: list[tuple[int, int, Deadline]] = []
        self._added = 0
        self._cancelled = 0

    def __len__(self) -> int:
        return len(self._heap) - self._cancelled

    def add(self, time_ns: int, callback: Callback) -> Deadline:
        """Remember a callback."""
        deadline = Deadline(time_ns, callback, self)
        self._added += 1
        heapq.heappush(self._heap, (time_ns, self._added, deadline))
        return deadline

    def next_ns(self) -> int | None:
        """Return the earliest time; None when nothing waits."""
        heap = self._heap
        while heap and heap[0][2].callback is None:
            heapq.heappop(heap)
            self._cancelled -= 1
        return heap[0][0] if heap else None

    def pop_due(self, now_ns: int) -> Callback | None:
        """Take out the first callback whose time has come; None when there is none."""
        heap = self._heap
        while heap and heap[0][0] <= now_ns:
            deadline = heapq.heappop(heap)[2]
            callback, deadline.callback = deadline.callback, None
            if callback is not None:
                return callback
            self._cancelled -= 1
        return None

    def forget_one(self) -> None:
        """Note that a deadline was cancelled (called by the deadline itself)."""
        self._cancelled += 1
        if self._cancelled > _FEW and self._cancelled * 2 > len(self._heap):
            self._heap = [entry for entry in self._heap if entry[2].callback is not None]
            heapq.heapify(self._heap)
            self._cancelled = 0
