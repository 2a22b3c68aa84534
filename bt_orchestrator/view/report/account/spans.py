"""Stops of the line one by one: spans of time with one loss and one cause."""

from __future__ import annotations

import heapq
from array import array
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from bt_orchestrator.view.report.account.losses import WORDS, Loss
from bt_orchestrator.view.report.account.slot import (
    LEAST_BREAKDOWN_US,
    LEAST_STOP_US,
    Slot,
    StopSpan,
)
from bt_orchestrator.view.report.account.stops import Stop

MOST_STOPS = 200
"""Stops that an account lists one by one: the longest. Of all others number and time."""


class LineStop(NamedTuple):
    """One stop of the line, as far as it is in planned time."""

    span: StopSpan
    us: int
    """Planned time of it."""

    @property
    def about(self) -> str:
        """Its loss and its cause, in words."""
        span = self.span
        summed = Stop(span.loss, span.detail, span.component, 1, self.us)
        return ', '.join(filter(None, (WORDS[span.loss].title, summed.about)))


class SpanTotal:
    """Takes in the stops of one slot after another."""

    def __init__(self) -> None:
        self._open: StopSpan | None = None
        """The last one, which may go on."""
        self._us = 0
        """Planned time of it so far."""
        self._count = self._sum_us = 0
        self._longest: list[tuple[int, int, LineStop]] = []
        self._faults: dict[str, array[int]] = {}
        """By component, the time of each own fault that may be a breakdown."""

    def add(self, slot: Slot, *, is_planned: bool) -> None:
        """Take in the stops of the next slot."""
        for span in slot.spans:
            if self._open is None or self._open.seq != span.seq:
                self._close()
                self._open, self._us = replace(span), 0
            self._open.until_us = span.until_us
            if is_planned:
                self._us += span.until_us - max(span.since_us, slot.begin_us)

    def _close(self) -> None:
        span, us, self._open = self._open, self._us, None
        if span is None or not us or span.long_us < LEAST_STOP_US:
            return
        self._count += 1
        self._sum_us += us
        if span.loss is Loss.OWN_FAULT and us >= LEAST_BREAKDOWN_US:
            self._faults.setdefault(span.component, array('q')).append(us)
        entry = (us, -span.seq, LineStop(span, us))
        if len(self._longest) < MOST_STOPS:
            heapq.heappush(self._longest, entry)
        else:
            heapq.heappushpop(self._longest, entry)

    def stops(self) -> tuple[tuple[LineStop, ...], int, int, Mapping[str, Sequence[int]]]:
        """Return the longest in their order, of all number and time, and the long own faults.

        No further slot is taken in after that.
        """
        self._close()
        stops = sorted((stop for _, _, stop in self._longest), key=lambda one: one.span.since_us)
        faults = {name: tuple(sorted(found)) for name, found in sorted(self._faults.items())}
        return tuple(stops), self._count, self._sum_us, faults
