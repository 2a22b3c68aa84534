"""Making books: the account of a journal, slot after slot, to be kept when events are removed.

Books go on where the last ones end. If the events after those are gone, their time is not
recorded, and the books go on with the first event that is there.
"""

from __future__ import annotations

from collections.abc import Callable

from bt_orchestrator.model import events as e
from bt_orchestrator.model.books import Books, KeptScript, KeptSlot, KeptState
from bt_orchestrator.model.records import Wanted
from bt_orchestrator.ports import Records
from bt_orchestrator.view.report.account.booked import (
    keep_script,
    keep_slot,
    keep_state,
    last_booked,
    read_state,
    read_steady,
)
from bt_orchestrator.view.report.account.course import EVER_US, FOLLOWED, Course
from bt_orchestrator.view.report.account.planned import US, us_of
from bt_orchestrator.view.report.account.slot import QUARTER_US, Slot
from bt_orchestrator.view.report.account.slots import Slots
from bt_orchestrator.view.report.account.steady_time import SteadyTime
from bt_orchestrator.view.report.reading import Reading

MOST_EVENTS = 100_000
"""Events that are taken in at a time: a few seconds, and a message of some 100 kB."""

STATE_EVERY = 50_000
"""Events after which a state stays: so many are read again at most to look into a slot."""

_DAY_US = 24 * 3600 * US


def next_books(records: Records, tell: Callable[[str], None], most: int = MOST_EVENTS) -> Books:
    """Return the next books of a journal.

    :param tell: called with a sentence for each damage
    :param most: events that are taken in, at most
    :raises JournalUnusable: it cannot be read
    """
    return _Bookkeeper(Reading(records, tell)).books(most)


class _Bookkeeper:
    def __init__(self, reading: Reading) -> None:
        self._reading = reading
        self._extent = reading.records.extent()
        self._slots: list[KeptSlot] = []
        self._states: list[KeptState] = []
        self._scripts: dict[str, KeptScript] = {}
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
        )

    def _take(self, slot: Slot) -> None:
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
