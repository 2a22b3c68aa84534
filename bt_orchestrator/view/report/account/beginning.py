"""Where an account of a period begins: at the state of the cell that the events before it left.

With books an account goes on where these end. Whole slots are taken from them. Where planned time
begins or ends within a slot, the events of that slot are read, from the last kept state before it;
if they were removed, planned time is rounded to the slot.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import pairwise

from bt_orchestrator.model.events import Event
from bt_orchestrator.model.keeping.records import Wanted
from bt_orchestrator.model.script import Script
from bt_orchestrator.view.report.account.booked import (
    booked,
    given_reasons,
    read_state,
    script_of,
    steady_time,
)
from bt_orchestrator.view.report.account.course import Bookings, Course
from bt_orchestrator.view.report.account.fold import FOLLOWED, AccountFold, Begun, FromBooks
from bt_orchestrator.view.report.account.losses import Loss
from bt_orchestrator.view.report.account.period import Period
from bt_orchestrator.view.report.account.planned import US, Planned, us_of
from bt_orchestrator.view.report.account.slot import Slot, StopSum
from bt_orchestrator.view.report.account.slots import Slots
from bt_orchestrator.view.report.account.total import Total
from bt_orchestrator.view.report.reading import Reading


def fold_at(reading: Reading, period: Period) -> tuple[AccountFold, Wanted]:
    """Return a fold that has taken in all before a period, and what it has to read from there.

    :param period: in steady time
    """
    pieces, events = period.planned.pieces, EventCourse(reading)
    begin = pieces[0][0] if pieces else period.begin_us
    if not events.comes_to(begin):
        events.begin_at(begin)
    begun = Begun(
        events.course,
        Total(given_reasons(reading)),
        begin,
        None,
        FromBooks(),
        _scripts(reading),
        steady_time(reading),
    )
    return _up_to(reading, period, AccountFold(period.planned, begun=begun), events.seq)


def fold_with_books(reading: Reading, period: Period) -> tuple[AccountFold, Wanted]:
    """Return a fold that has taken in what of a period is in books, too, and what it has to read.

    :param period: in steady time
    """
    return _Beginning(reading, period).fold()


def _up_to(
    reading: Reading, period: Period, fold: AccountFold, seq: int
) -> tuple[AccountFold, Wanted]:
    """Let a fold take in the events after one that are before a period."""
    steady = steady_time(reading)
    latest = steady.latest_clock_us(seq, period.end_us) + 0.5  # what is rounded to it is in it
    wanted = Wanted(events=FOLLOWED, after_seq=seq, until=latest / US)
    for event in map(steady.of, reading.events(wanted)):
        if us_of(event.time) >= period.begin_us:
            break
        fold.follow(event)
        wanted = wanted.past(event.seq)
    return fold, wanted


def _scripts(reading: Reading) -> Callable[[str], Script | None]:
    return lambda digest: script_of(reading, digest) or reading.script(digest)


class _Beginning:
    """Takes in slots, and events where slots do not suffice, in the order of their time."""

    def __init__(self, reading: Reading, period: Period) -> None:
        self._reading = reading
        self._period = period
        self._planned = period.planned
        self._borders = [moment for piece in period.planned.pieces for moment in piece]
        self._total = Total(given_reasons(reading))
        self._now = self._borders[0] if self._borders else period.begin_us
        """Up to when slots were taken in."""
        self._last: Slot | None = None
        """The newest of them, if it is not in the total yet: more may happen at its end."""
        self._steady = steady_time(reading)
        self._events = EventCourse(reading)
        self._used: list[int] = []
        """From when to when there were slots in books."""
        self._rounded: list[int] = []

    def fold(self) -> tuple[AccountFold, Wanted]:
        """Take in what is in books, and the events that lead to where the rest begins."""
        end = self._period.end_us
        for slot in booked(self._reading, self._now, end):
            self._add_last()
            if slot.begin_us > self._now and not self._look(slot.begin_us):
                self._add_parts(_unknown(self._now, slot.begin_us))
            self._take(slot, end)
        fold = self._going_on(end)
        return _up_to(self._reading, self._period, fold, self._events.seq)

    def _going_on(self, end: int) -> AccountFold:
        if self._now < end and not self._events.comes_to(self._now):
            self._events.begin_at(self._now)
        if self._now >= end:
            self._events.begin_at(self._now)
            self._events.seq = self._reading.records.extent().last_seq
        course = self._events.course
        if course.now != self._now:
            self._add_last()
        books = FromBooks(tuple(self._used), tuple(self._rounded), self._events.read_seqs)
        begun = Begun(
            course,
            self._total,
            self._now,
            self._last,
            books,
            _scripts(self._reading),
            self._steady,
        )
        return AccountFold(self._planned, begun=begun)

    # --- slots ------------------------------------------------------------------------------

    def _take(self, slot: Slot, end: int) -> None:
        """Take in a slot of the books, or the events of its time."""
        begin, until = max(slot.begin_us, self._now), min(slot.until_us, end)
        if begin >= until:
            return
        if (begin, until) == (slot.begin_us, slot.until_us) and not self._within(begin, until):
            self._last, self._now = slot, until
        elif slot.is_steady:
            self._add_parts(slot.part(begin, until))
        elif self._look(until):
            return
        else:
            self._round(slot)
        self._used = [*(self._used[:1] or [begin]), self._now]

    def _within(self, begin: int, until: int) -> list[int]:
        return [border for border in self._borders if begin < border < until]

    def _add_parts(self, slot: Slot) -> None:
        """Add a steady slot, a part of it for each stretch of planned or other time."""
        moments = [slot.begin_us, *self._within(slot.begin_us, slot.until_us), slot.until_us]
        for begin, until in pairwise(moments):
            self._add(slot.part(begin, until))

    def _round(self, slot: Slot) -> None:
        """Take all of a slot as planned, or nothing, as the events in it are gone."""
        begin, until = slot.begin_us, slot.until_us
        if not self._borders:
            self._now = until  # no time is planned, here nor elsewhere
            return
        within = self._planned.between(begin, until)
        if 2 * within >= until - begin or within == self._planned.total_us:
            self._planned = Planned.of([*self._planned.pieces, (begin, until)])
        else:
            self._planned = Planned.of(self._planned.pieces, [(begin, until)])
        self._rounded.append(begin)
        is_planned = self._planned.includes(until)
        if is_planned or (begin >= self._borders[0] and until <= self._period.end_us):
            self._add(slot)
        self._now = until

    def _add_last(self) -> None:
        if self._last is not None:
            self._add(self._last)
            self._last = None

    def _add(self, slot: Slot) -> None:
        self._total.add(slot, is_planned=self._planned.includes(slot.until_us))
        self._now = max(self._now, slot.until_us)

    # --- events -----------------------------------------------------------------------------

    def _look(self, until: int) -> bool:
        """Take in the events up to a moment, if they are there; tell whether they are."""
        if not self._events.comes_to(self._now):
            return False
        course = self._events.course
        borders = [*self._borders, until]
        ledger = Slots(course.holds, self._add, self._now, borders, steady=self._steady)
        ledger.runs(course.cell, course.digest)
        self._events.read(self._now, until, ledger)
        ledger.close()
        return True


def _unknown(begin: int, until: int) -> Slot:
    """Return a slot without any known time."""
    stop = StopSum(Loss.NOT_RECORDED, begun=1, us=until - begin)
    return Slot(begin, until, stops=(stop,), is_steady=True)


# A course through the events of a journal, from a kept state on, each event at most once.


class EventCourse:
    """Goes forward only, in steady time."""

    def __init__(self, reading: Reading) -> None:
        self._reading = reading
        self._steady = steady_time(reading)
        self._first_seq = reading.records.extent().first_seq
        self._begin_at(Course(is_whole=self._first_seq == 1), self._first_seq - 1)
        self._has_begun = False
        self.read_seqs: tuple[int, ...] = ()
        """The first and the last event that was read and counts; empty: none was."""

    def _begin_at(self, course: Course, seq: int) -> None:
        self.course, self.seq = course, seq
        self._events: Iterator[Event] | None = None
        self._next: Event | None = None

    def begin_at(self, moment: int) -> None:
        """Begin with the first event that is kept; the time from a moment on passes before it."""
        self._begin_at(Course(is_whole=self._first_seq == 1, begin=moment), self._first_seq - 1)

    def comes_to(self, moment: int) -> bool:
        """Tell whether it is at a moment, or before it; go on to a kept state, if that is near."""
        kept = self._reading.records.book_state(moment, self._first_seq - 1)
        if kept is not None and (kept.seq > self.seq or not self._has_begun):
            course = read_state(kept)
            if course is not None:
                self._begin_at(course, kept.seq)
                self._has_begun = True
        if not self._has_begun and self._first_seq > 1:
            return False
        now = self.course.now
        if now is None:
            event = self._ahead()
            now = None if event is None else us_of(event.time)
        return now is not None and now <= moment

    def read(self, since: int, until: int, ledger: Bookings) -> None:
        """Take in the events up to a moment, and the time; those since another one count."""
        self._has_begun = True
        while (event := self._ahead()) is not None and us_of(event.time) <= until:
            self.course.follow(event, ledger)
            self.seq, self._next = event.seq, None
            if us_of(event.time) >= since:
                self.read_seqs = (*(self.read_seqs[:1] or (event.seq,)), event.seq)
        if event is not None:
            self.course.pass_until(event, ledger, until)
        else:
            rest = self.course.rest(until)
            if rest is not None:
                ledger.passes(rest)

    def _ahead(self) -> Event | None:
        """Return the next event, which is not taken in yet."""
        if self._next is None:
            if self._events is None:
                wanted = Wanted(events=FOLLOWED, after_seq=self.seq)
                self._events = map(self._steady.of, self._reading.events(wanted))
            self._next = next(self._events, None)
        return self._next
