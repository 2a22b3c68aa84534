"""A course through the events of a journal, from a kept state on, each event at most once."""

from __future__ import annotations

from collections.abc import Iterator

from bt_orchestrator.model.events import Event
from bt_orchestrator.model.records import Wanted
from bt_orchestrator.view.report.account.booked import steady_time
from bt_orchestrator.view.report.account.course import FOLLOWED, Bookings, Course
from bt_orchestrator.view.report.account.kept import read_state
from bt_orchestrator.view.report.account.planned import us_of
from bt_orchestrator.view.report.reading import Reading


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
