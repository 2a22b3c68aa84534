"""Reading the books of a journal."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from bt_orchestrator.model.books import KeptSlot
from bt_orchestrator.model.events import OrchestratorStarted
from bt_orchestrator.model.records import Damage, Wanted
from bt_orchestrator.model.script import Script
from bt_orchestrator.view.report.account.course import EVER_US, FOLLOWED
from bt_orchestrator.view.report.account.kept import read_script, read_slot, read_steady
from bt_orchestrator.view.report.account.slot import Slot
from bt_orchestrator.view.report.account.steady_time import STEPS, SteadyTime
from bt_orchestrator.view.report.reading import Reading

_AT_ONCE, _LOOK_AT = 1000, 10

OTHER_VERSION = Damage(
    'the books of the account are partly those of another version of this program; their time '
    'counts as not recorded',
    0,
)


def booked(reading: Reading, begin_us: int, end_us: int) -> Iterator[Slot]:
    """Yield the sound slots that lie between two moments, or touch what does."""
    begin: int | None = begin_us
    while begin is not None:
        page = reading.records.booked(begin, end_us, _AT_ONCE)
        reading.tell_new(page.damage)
        yield from _sound(reading, page.slots)
        begin = page.rest_us


def first_booked(reading: Reading) -> Slot | None:
    """Return the first sound slot; None: there is none among the first ones."""
    return _at_an_end(reading, newest_first=False)


def last_booked(reading: Reading) -> Slot | None:
    """Return the last sound slot; None: there is none among the last ones."""
    return _at_an_end(reading, newest_first=True)


def _at_an_end(reading: Reading, *, newest_first: bool) -> Slot | None:
    page = reading.records.booked(-EVER_US, EVER_US, _LOOK_AT, newest_first=newest_first)
    reading.tell_new(page.damage)
    return next(_sound(reading, page.slots), None)


def script_of(reading: Reading, digest: str) -> Script | None:
    """Return a script whose work is in the books; None: it is not in them."""
    kept = reading.records.book_script(digest)
    return None if kept is None else read_script(kept)


def steady_time(reading: Reading) -> SteadyTime:
    """Return what is known of the steps of the clock, from books and from the events after them.

    A reading has one, which takes in further events.
    """
    if reading.steady is None:
        kept = reading.records.book_state(EVER_US)
        steady = (read_steady(kept) if kept is not None else None) or SteadyTime()
        for event in reading.events(Wanted(steady.known, events=STEPS)):
            if isinstance(event, OrchestratorStarted):
                _follow_last(reading, steady, Wanted(before_seq=event.seq))
            steady.follow(event)
        _follow_last(reading, steady, Wanted())
        reading.steady = steady
    return reading.steady


def _follow_last(reading: Reading, steady: SteadyTime, wanted: Wanted) -> None:
    """Take in the last of some events: a start of a node is compared with it."""
    wanted = replace(wanted, after_seq=steady.known, events=FOLLOWED, newest_first=True)
    last = reading.first(wanted)
    if last is not None:
        steady.follow(last)


def _sound(reading: Reading, slots: Sequence[KeptSlot]) -> Iterator[Slot]:
    for kept in slots:
        slot = read_slot(kept)
        if slot is None:
            reading.tell_new([OTHER_VERSION])
        else:
            yield slot
