"""How long ticks take and how often they come."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from statistics import fmean, pvariance
from typing import NamedTuple, TypeVar

_T = TypeVar('_T')

WINDOW = 100
"""Averages are over so many ticks: they show the present work of the cell."""


class Measured(NamedTuple):
    """Seconds."""

    last: float
    average: float
    variance: float


class TickStatistics:
    """Counts and times ticks. A tick here is a settle: all that one piece of news leads to."""

    def __init__(self, clock: Callable[[], float] = time.perf_counter) -> None:
        self.count = 0
        self._clock = clock
        self._started: float | None = None
        self._durations: deque[float] = deque(maxlen=WINDOW)
        self._intervals: deque[float] = deque(maxlen=WINDOW)

    def timed(self, settle: Callable[[], _T]) -> Callable[[], _T]:
        """Return the same call, measured."""

        def call() -> _T:
            started = self._clock()
            if self._started is not None:
                self._intervals.append(started - self._started)
            self._started = started
            self.count += 1
            try:
                return settle()
            finally:
                self._durations.append(self._clock() - started)

        return call

    @property
    def duration(self) -> Measured:
        """Time that ticks take."""
        return _measured(self._durations)

    @property
    def interval(self) -> Measured:
        """Time from the start of one tick to the start of the next."""
        return _measured(self._intervals)


def _measured(values: deque[float]) -> Measured:
    if not values:
        return Measured(0.0, 0.0, 0.0)
    # Rounding must not make it negative: watchers take the root.
    return Measured(values[-1], fmean(values), max(pvariance(values), 0.0))
