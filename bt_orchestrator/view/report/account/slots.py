"""The ledger that cuts time into slots; each is added up by itself."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from copy import deepcopy

from bt_orchestrator.model import events as e
from bt_orchestrator.model.task_spans import TaskSpan
from bt_orchestrator.view.report.account.course import EVER_US, Stretch
from bt_orchestrator.view.report.account.made import Left
from bt_orchestrator.view.report.account.open_slot import OpenSlot
from bt_orchestrator.view.report.account.slot import QUARTER_US, Slot
from bt_orchestrator.view.report.account.steady_time import SteadyTime
from bt_orchestrator.view.report.account.stops import Held, OpenHolds


class Slots:
    """Books on slots that end at quarters of an hour, and at some more borders.

    The quarters are those of the clock, and a slot ends where the clock was set. A long time
    without an event is one slot, from quarter to quarter. Implements `Bookings`.
    """

    def __init__(
        self,
        holds: OpenHolds,
        take: Callable[[Slot], None],
        begin: int | None = None,
        borders: Sequence[int] = (),
        *,
        steady: SteadyTime,
    ) -> None:
        """Begin.

        :param holds: those that stand, as a course knows them
        :param take: called with each slot that is complete, in their order
        :param begin: what was before is not booked; None: all is
        :param borders: further ends of slots, in order
        :param steady: knows when the clock was set
        """
        self._holds = holds
        self._take = take
        self._begin = begin
        self._borders = borders
        self._steady = steady
        self._open: OpenSlot | None = None
        self._cell = self._digest = ''

    def go_on_from(self, slot: Slot) -> None:
        """Go on with a slot that is not complete, or may be: more may happen at its end."""
        ends = max(self._border(slot.begin_us), slot.until_us)
        self._open = OpenSlot(slot.begin_us, ends, '', '')
        self._open.go_on_from(slot)

    def passes(self, stretch: Stretch) -> None:
        """Let time pass."""
        begin, end, cause, goes_on = stretch
        if self._begin is not None and begin < self._begin:
            begin, goes_on = self._begin, True
        while begin < end:
            slot = self._slot_at(begin, end)
            until = min(end, slot.ends)
            slot.passes(Stretch(begin, until, cause, goes_on), self._holds.open.values())
            begin, goes_on = until, True

    def raised(self, held: Held, *, is_busy: bool) -> None:
        """Take in a hold."""
        if self._open is not None:
            self._open.raised(held, is_busy=is_busy)

    def released(self, held: Held) -> None:
        """Take in that a hold is over."""
        if self._open is not None:
            self._open.released(held)

    def failed(self, event: e.TaskFailed, span: TaskSpan | None) -> None:
        """Take in an attempt that failed."""
        if self._open is not None:
            self._open.failed(event, span)

    def left(self, item: Left) -> None:
        """Take in an item that left the line."""
        if self._open is not None:
            self._open.left(item)

    def runs(self, cell: str, digest: str) -> None:
        """Take in that a node began to run with a cell file; before the begin: that it runs."""
        self._cell, self._digest = cell, digest
        if self._open is not None:
            self._open.runs(cell, digest)

    def until(self, rest: Stretch | None) -> Sequence[Slot]:
        """Return what is not complete, with some more time, and change nothing."""
        found: list[Slot] = []
        more = Slots(self._holds, found.append, self._begin, self._borders, steady=self._steady)
        more._open, more._cell, more._digest = deepcopy(self._open), self._cell, self._digest
        if rest is not None:
            more.passes(rest)
        more.close()
        return found

    def close(self) -> None:
        """Hand over the last slot, as far as it has gone."""
        if self._open is not None:
            self._take(self._open.slot(self._holds.open.values()))
            self._open = None

    def _slot_at(self, begin: int, end: int) -> OpenSlot:
        """Return the slot in which time goes on, to a moment after it."""
        if self._open is None or self._ends(self._open) <= begin:
            self.close()
            ends = self._border(begin)
            if ends < end and ends == self._quarter(ends):
                ends = max(ends, self._border_before(end, begin))
            self._open = OpenSlot(begin, ends, self._cell, self._digest)
        return self._open

    def _ends(self, slot: OpenSlot) -> int:
        """Return when a slot ends: the clock may have been set since it was begun."""
        return (
            min(slot.ends, self._steady.step_after(slot.begin))
            if self._steady.steps
            else slot.ends
        )

    def _border(self, moment: int) -> int:
        """Return the first border after a moment."""
        return min(self._quarter(moment) + QUARTER_US, self._special(moment))

    def _border_before(self, end: int, begin: int) -> int:
        """Return the last quarter before a moment, to which no other border is in the way."""
        return min(self._quarter(end - 1), self._special(begin))

    def _quarter(self, moment: int) -> int:
        """Return the last quarter of the clock that is not after a moment."""
        return moment - self._steady.clock_us(moment) % QUARTER_US

    def _special(self, moment: int) -> int:
        at = bisect_right(self._borders, moment)
        border = self._borders[at] if at < len(self._borders) else EVER_US
        return min(border, self._steady.step_after(moment))
