"""Making books: the account of a journal, slot after slot, to be kept when events are removed.

Books go on where the last ones end. If the events after those are gone, their time is not
recorded, and the books go on with the first event that is there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import chain

from bt_orchestrator.model import events as e
from bt_orchestrator.model.keeping.books import Books, KeptReason, KeptScript, KeptSlot, KeptState
from bt_orchestrator.model.keeping.records import Wanted
from bt_orchestrator.ports import Records
from bt_orchestrator.view.report.account.booked import (
    keep_reason,
    keep_script,
    keep_slot,
    keep_state,
    last_booked,
    read_slot,
    read_state,
    read_steady,
)
from bt_orchestrator.view.report.account.course import EVER_US, FOLLOWED, Course
from bt_orchestrator.view.report.account.planned import US, us_of
from bt_orchestrator.view.report.account.slot import LEAST_STOP_US, QUARTER_US, Slot
from bt_orchestrator.view.report.account.slots import Slots
from bt_orchestrator.view.report.account.steady_time import SteadyTime
from bt_orchestrator.view.report.line_stops import gives_later
from bt_orchestrator.view.report.reading import Reading

MOST_EVENTS = 100_000
"""Events that are taken in at a time: a few seconds, and a message of some 100 kB."""

STATE_EVERY = 50_000
"""Events after which a state stays: so many are read again at most to look into a slot."""

LOOK_AT = 3
"""Slots of later events in which a stop is looked for: it may begin at the end of the first."""

_DAY_US = 24 * 3600 * US


def next_books(records: Records, tell: Callable[[str], None], most: int = MOST_EVENTS) -> Books:
    """Return the next books of a journal.

    :param tell: called with a sentence for each damage
    :param most: events that are taken in, at most
    :raises JournalUnusable: it cannot be read
    """
    return _Bookkeeper(Reading(records, tell)).books(most)


def has_stop(records: Records, seq: int, now: float, tell: Callable[[str], None]) -> bool:
    """Tell whether a stop of the line began with an event: in books, or after them.

    :param now: seconds since the epoch: a stop may stand
    :raises JournalUnusable: it cannot be read
    """
    reading = Reading(records, tell)
    slots = chain(_slots_about(reading, seq), _Bookkeeper(reading).rest(now))
    return any(
        span.seq == seq and span.long_us >= LEAST_STOP_US for slot in slots for span in slot.spans
    )


def _slots_about(reading: Reading, seq: int) -> Iterator[Slot]:
    """Yield the slots of the books in which a stop may be that began with an event."""
    begin: int | None = -EVER_US
    later = 0
    while begin is not None and later < LOOK_AT:
        page = reading.records.booked(begin, EVER_US)
        for kept in page.slots:
            slot = read_slot(kept) if kept.made_of >= seq and later < LOOK_AT else None
            later += kept.made_of > seq
            if slot is not None:
                yield slot
        begin = page.rest_us


class _Bookkeeper:
    def __init__(self, reading: Reading) -> None:
        self._looked: list[Slot] | None = None
        """Slots that are looked at in place of being kept; None: they are kept."""
        self._reading = reading
        self._extent = reading.records.extent()
        self._slots: list[KeptSlot] = []
        self._states: list[KeptState] = []
        self._scripts: dict[str, KeptScript] = {}
        self._reasons: list[KeptReason] = []
        last = last_booked(reading)
        state = reading.records.book_state(EVER_US, self._extent.first_seq - 1)
        course = None if state is None else read_state(state)
        newest = reading.records.book_state(EVER_US)  # also if the events after it are gone
        self._steady = (None if newest is None else read_steady(newest)) or SteadyTime()
        self._end_us = None if last is None else last.until_us
        if course is None or state is None:
            is_whole = self._extent.first_seq == 1
            self._course = Course(is_whole=is_whole, begin=self._end_us)
            self._seq = self._extent.first_seq - 1
        else:
            self._course, self._seq = course, state.seq
        self._stays_since = self._made_of = self._seq
        self._ledger = Slots(self._course.holds, self._take, self._end_us, steady=self._steady)
        self._ledger.runs(self._course.cell, self._course.digest)
        if course is not None and last is not None and last.until_us == course.now:
            self._ledger.go_on_from(last)

    def books(self, most: int) -> Books:
        reached = min(self._extent.last_seq, self._seq + most)
        wanted = Wanted(after_seq=self._seq, before_seq=reached + 1, events=FOLLOWED)
        for event in map(self._steady.of, self._reading.events(wanted)):
            self._made_of = event.seq
            self._keep_a_state(event)
            self._course.follow(event, self._ledger)
            if isinstance(event, e.ScriptLoaded):
                self._scripts[event.digest] = keep_script(event.digest, event.definition)
            elif isinstance(event, e.OperatorDecided) and gives_later(event):
                ahead_s = self._steady.ahead_of(event.seq) / US
                by_the_clock = event.stamped(event.seq, event.time + ahead_s)
                self._reasons.append(keep_reason(by_the_clock))
        self._ledger.close()
        if self._course.now is not None:
            newest = keep_state(self._course, self._steady, reached, reached, stays=False)
            self._states.append(newest)
        return Books(
            self._extent.history,
            reached,
            reached == self._extent.last_seq,
            self._slots,
            self._states,
            list(self._scripts.values()),
            self._reasons,
        )

    def rest(self, now: float) -> Iterator[Slot]:
        """Yield what is in no books yet, up to a moment; it is not kept."""
        looked: list[Slot] = []
        self._looked = looked
        wanted = Wanted(after_seq=self._seq, events=FOLLOWED)
        for event in map(self._steady.of, self._reading.events(wanted)):
            self._course.follow(event, self._ledger)
            yield from looked
            looked.clear()
        ahead = self._steady.ahead_of(self._extent.last_seq)
        rest = self._course.rest(us_of(now) - ahead)
        if rest is not None:
            self._ledger.passes(rest)
        self._ledger.close()
        yield from looked

    def _take(self, slot: Slot) -> None:
        if self._looked is not None:
            self._looked.append(slot)
            return
        self._slots.append(keep_slot(slot, self._made_of))

    def _keep_a_state(self, event: e.Event) -> None:
        """Keep a state at the last quarter before an event, once a day and after many events."""
        now, before = self._course.now, us_of(event.time) - 1
        border = before - self._steady.clock_us(before) % QUARTER_US
        if now is None or border <= now:
            return
        is_other_day = border // _DAY_US != now // _DAY_US
        if is_other_day or event.seq - self._stays_since >= STATE_EVERY:
            self._stays_since = event.seq
            self._course.pass_until(event, self._ledger, border)
            seq = event.seq - 1
            state = keep_state(self._course, self._steady, seq, event.seq, stays=True)
            self._states.append(state)
