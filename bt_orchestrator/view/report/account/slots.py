"""The ledger that cuts time into slots; each is added up by itself."""

from __future__ import annotations

from bisect import bisect_right
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from copy import deepcopy
from dataclasses import replace

from bt_orchestrator.model import events as e
from bt_orchestrator.model.task_spans import TaskSpan
from bt_orchestrator.view.report.account.causes.flaws import Bounds, Flaw, FlawSum, MeasuredSum
from bt_orchestrator.view.report.account.causes.made import Happening, Made, Measured, count
from bt_orchestrator.view.report.account.course import EVER_US, Stretch, is_busy
from bt_orchestrator.view.report.account.losses import Loss, Part, is_stop
from bt_orchestrator.view.report.account.slot import (
    LEAST_STOP_US,
    MOST_SPANS,
    QUARTER_US,
    FailedSum,
    RestOfHolds,
    Slot,
    StopSpan,
    StopSum,
)
from bt_orchestrator.view.report.account.standing import Cause
from bt_orchestrator.view.report.account.steady_time import SteadyTime
from bt_orchestrator.view.report.account.stops import MOST_HOLDS, Held, OpenHolds, without_times


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
        begin, end, goes_on = stretch.begin, stretch.end, stretch.goes_on
        if self._begin is not None and begin < self._begin:
            begin, goes_on = self._begin, True
        while begin < end:
            slot = self._slot_at(begin, end)
            until = min(end, slot.ends)
            part = stretch._replace(begin=begin, end=until, goes_on=goes_on)
            slot.passes(part, self._holds.open.values())
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

    def happened(self, what: Happening) -> None:
        """Take in what became of an item."""
        if self._open is not None:
            self._open.happened(what)

    def runs(self, cell: str, digest: str) -> None:
        """Take in that a node began to run with a cell file; before the begin: that it runs."""
        self._cell, self._digest = cell, digest
        if self._open is not None:
            self._open.runs(cell, digest)

    def until(self, rest: Stretch | None) -> Sequence[Slot]:
        """Return what is not complete, with some more time, and change nothing."""
        slots: list[Slot] = []
        more = Slots(self._holds, slots.append, self._begin, self._borders, steady=self._steady)
        more._open, more._cell, more._digest = deepcopy(self._open), self._cell, self._digest
        if rest is not None:
            more.passes(rest)
        more.close()
        return slots

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


# One slot of an account while it is added up.


class OpenSlot:
    """Takes in stretches of time, and what happens, from one moment to another."""

    def __init__(self, begin: int, ends: int, cell: str, digest: str) -> None:
        """Begin.

        :param ends: when it ends at the latest
        :param cell: name and digest of the cell that the node runs with; empty: not known
        """
        self.begin, self.ends, self.now = begin, ends, begin
        self._producing = 0
        self._stops: dict[tuple[Loss, str, str, Part], StopSum] = {}
        self._spans: dict[int, StopSpan] = {}
        self._held: dict[str, Held] = {}
        self._released: list[Held] = []
        self._before: set[str] = set()
        """Holds that had been raised before."""
        self._made: dict[tuple[str, str], Made] = {}
        self._failed: Counter[tuple[str, str, str]] = Counter()
        self._took: Counter[tuple[str, str, str]] = Counter()
        self._flaws: Counter[Flaw] = Counter()
        self._measured: dict[Bounds, MeasuredSum] = {}
        self._operated: Counter[str] = Counter()
        self._working: tuple[str, ...] | None = None
        self._cell = cell
        self._cells = dict.fromkeys([digest] if digest else ())
        self._is_steady = True

    def go_on_from(self, slot: Slot) -> None:
        """Know what a slot that was not complete has added up."""
        self.now, self._producing = slot.until_us, slot.producing_us
        self._stops = {stop.key: stop for stop in slot.stops}
        self._spans = {span.seq: replace(span) for span in slot.spans}
        self._released = [hold for hold in slot.holds if hold.released_us is not None]
        self._held = {hold.hold: hold for hold in slot.holds if hold.released_us is None}
        self._before = {hold.hold for hold in slot.holds if hold.raised_us <= slot.begin_us}
        self._made = {(job.job, job.digest): job for job in slot.made}
        for failure in slot.failed:
            key = (failure.component, failure.task, failure.reason)
            self._failed[key], self._took[key] = failure.times, failure.us
        self._flaws.update({flaw.of: flaw.times for flaw in slot.flaws})
        self._measured = {measurement.of: measurement for measurement in slot.measured}
        self._operated.update(slot.operated_us)
        self._working = tuple(slot.operated_us) if slot.is_steady else None
        self._cell, self._cells = slot.cell, dict.fromkeys(slot.cells)
        self._is_steady = slot.is_steady
        self._rest_before = slot.rest
        self._lacks_causes = slot.lacks_causes

    _rest_before: tuple[RestOfHolds, ...] = ()
    _lacks_causes = False

    def passes(self, stretch: Stretch, holds: Iterable[Held]) -> None:
        """Let time pass, within the slot.

        :param holds: that stand
        """
        us, cause = stretch.end - stretch.begin, stretch.cause
        is_first = self.now == self.begin
        self._is_steady &= is_first or (stretch.goes_on and stretch.working == self._working)
        self._working = stretch.working
        for name in stretch.working:
            self._operated[name] += us
        self.now = stretch.end
        if cause is None:
            self._producing += us
        else:
            new = StopSum(*cause[:3], part=cause.part)
            stop = self._stops.setdefault(new.key, new)
            stop.us += us
            stop.begun += not stretch.goes_on
            stop.goes_on |= stretch.goes_on and is_first
            if is_stop(cause.loss):
                self._stop(stretch, cause)
        busy = is_busy(cause)
        for hold in holds:
            held = self._held.get(hold.hold) or self._stands(hold, is_first=is_first)
            held.stood_us += us
            if cause is not None and cause.hold == hold.hold:
                held.loss = cause.loss
                held.lost_us += us
            if hold.component and busy:
                held.down_us += us

    def _stop(self, stretch: Stretch, cause: Cause) -> None:
        span = self._spans.get(stretch.seq)
        if span is None:
            span = StopSpan(stretch.seq, *cause, since_us=stretch.since)
            self._spans[stretch.seq] = span
        span.until_us = stretch.end
        span.code = stretch.code or span.code

    def _stands(self, held: Held, *, is_first: bool) -> Held:
        if is_first:
            self._before.add(held.hold)
        self._held[held.hold] = made = without_times(held)
        return made

    # --- what happens -------------------------------------------------------------------------

    def raised(self, held: Held, *, is_busy: bool) -> None:
        """Take in a hold."""
        self._is_steady = False
        self._stands(held, is_first=False).fails = bool(held.component) and is_busy

    def released(self, held: Held) -> None:
        """Take in that a hold is over."""
        self._is_steady = False
        sums = self._held.pop(held.hold, None)
        if sums is not None:
            sums.told_as(held)
            self._released.append(sums)

    def failed(self, event: e.TaskFailed, span: TaskSpan | None) -> None:
        """Take in an attempt that failed."""
        self._is_steady = False
        begun = span.started if span is not None else None
        key = (begun.component if begun else '', begun.name if begun else event.task, event.reason)
        self._failed[key] += 1
        self._took[key] += max(0, round(span.seconds * 1e6)) if span is not None else 0

    def happened(self, what: Happening) -> None:
        """Take in what became of an item."""
        self._is_steady = False
        if isinstance(what, Measured):
            known = self._measured.get(what.of)
            if known is None:
                known = MeasuredSum(what.of, what.value, what.value)
                self._measured[what.of] = known
            known.measured(what.value)
            return
        key = (what.of.job, what.of.digest)
        made = self._made.get(key)
        if made is None:
            made = self._made[key] = replace(what.of)
        count(made, what)
        if what.flaw is not None:
            self._flaws[what.flaw] += 1

    def runs(self, cell: str, digest: str) -> None:
        """Take in that a node began to run with a cell file."""
        self._is_steady = False
        self._cell = cell
        self._cells[digest] = None

    # --- the slot -----------------------------------------------------------------------------

    def slot(self, open_holds: Iterable[Held]) -> Slot:
        """Return it, as far as it has gone.

        :param open_holds: that stand, as they are told by now
        """
        for hold in open_holds:
            if hold.hold in self._held:
                self._held[hold.hold].told_as(hold)
        holds, rest = self._told()
        return Slot(
            self.begin,
            self.now,
            self._producing,
            tuple(self._stops.values()),
            holds,
            rest,
            tuple(self._made.values()),
            tuple(FailedSum(*key, n, self._took[key]) for key, n in self._failed.items()),
            tuple(FlawSum(flaw, n) for flaw, n in self._flaws.items()),
            tuple(self._measured.values()),
            dict(self._operated),
            self._cell,
            tuple(self._cells),
            self._is_steady,
            tuple(self._told_spans()),
            self._lacks_causes,
        )

    def _told_spans(self) -> Iterator[StopSpan]:
        """Yield the stops to tell one by one: those that go beyond the slot in any case."""
        spans = [
            span
            for span in self._spans.values()
            if span.long_us >= LEAST_STOP_US or span.until_us == self.now
        ]
        within = [span for span in spans if self.begin <= span.since_us < span.until_us < self.now]
        within.sort(key=lambda span: -span.long_us)
        left_out = {span.seq for span in within[MOST_SPANS:]}
        return (span for span in spans if span.seq not in left_out)

    def _told(self) -> tuple[tuple[Held, ...], tuple[RestOfHolds, ...]]:
        """Return the holds to tell one by one, and the sums of the others.

        Those that began or end in other slots are told in any case.
        """
        if len(self._released) <= MOST_HOLDS:
            return (*self._released, *self._held.values()), self._rest_before
        within = [hold for hold in self._released if hold.hold not in self._before]
        within.sort(key=lambda hold: (-hold.lost_us, -hold.stood_us))
        left_out = within[MOST_HOLDS:]
        gone = {hold.hold for hold in left_out}
        holds = [hold for hold in self._released if hold.hold not in gone]
        rests = {(rest.loss, rest.component): replace(rest) for rest in self._rest_before}
        for hold in left_out:
            rest = rests.setdefault(
                (hold.loss, hold.component), RestOfHolds(hold.loss, hold.component)
            )
            rest.told += bool(hold.stood_us)
            rest.lost_us += hold.lost_us
            rest.failures += bool(hold.component and (hold.fails or hold.down_us))
            rest.down_us += hold.down_us
        return (*holds, *self._held.values()), tuple(rests.values())
