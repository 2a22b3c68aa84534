"""Books of a journal: their text form, and reading them."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import TypeVar

from bt_orchestrator.model.codec import from_plain, json_of, known_event, text_of, to_text
from bt_orchestrator.model.events import OperatorDecided, OrchestratorStarted
from bt_orchestrator.model.keeping.books import KeptReason, KeptScript, KeptSlot, KeptState
from bt_orchestrator.model.keeping.records import Damage, Wanted
from bt_orchestrator.model.script import Script
from bt_orchestrator.view.report.account.course import EVER_US, FOLLOWED, Course
from bt_orchestrator.view.report.account.slot import Slot
from bt_orchestrator.view.report.account.steady_time import STEPS, SteadyTime
from bt_orchestrator.view.report.line_stops import GivenReasons
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
    return _known(reading)[0]


def given_reasons(reading: Reading) -> GivenReasons:
    """Return the reasons of stops that were given by now, in books and in the events after them.

    They are of all the journal: a stop may be classified long after it.
    """
    return _known(reading)[1]


def _known(reading: Reading) -> tuple[SteadyTime, GivenReasons]:
    """Return what one look through all of a journal tells."""
    if reading.steady is None or reading.reasons is None:
        kept = reading.records.book_state(EVER_US)
        steady = (read_steady(kept) if kept is not None else None) or SteadyTime()
        reasons = _booked_reasons(reading)
        names = (*STEPS, OperatorDecided.event)
        for event in reading.events(Wanted(steady.known, events=names)):
            reasons.follow(event)
            if isinstance(event, OrchestratorStarted):
                _follow_last(reading, steady, Wanted(before_seq=event.seq))
            if event.event in STEPS:
                steady.follow(event)
        _follow_last(reading, steady, Wanted())
        reading.steady, reading.reasons = steady, reasons
    return reading.steady, reading.reasons


def _booked_reasons(reading: Reading) -> GivenReasons:
    reasons, after = GivenReasons(), 0
    while True:
        page = reading.records.book_reasons(after, _AT_ONCE)
        reading.tell_new(page.damage)
        for kept in page.reasons:
            event = known_event(json.loads(kept.text))
            if event is not None:
                reasons.follow(event)
        if page.rest_seq is None:
            return reasons
        after = page.rest_seq


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


# The text form of books: slots, the state of a course, scripts.

_T = TypeVar('_T')

BOOKS_VERSION = 4
"""Of what the texts mean. Books of another version are not read: their time is not recorded."""

WITHOUT_STEPS, WITHOUT_STOPS, WITHOUT_CAUSES = 1, 2, 3
"""Versions before, which are read: the first leaves out time if a clock was set back, the first
two tell no stop by itself, and no causes of scrap and rework and no times of work are in any."""

OLDER_VERSIONS = (WITHOUT_STEPS, WITHOUT_STOPS, WITHOUT_CAUSES)


def keep_slot(slot: Slot, made_of: int) -> KeptSlot:
    """Return a slot as text.

    :param made_of: seq of the last event that has a say in it
    """
    return KeptSlot(slot.begin_us, slot.until_us, made_of, BOOKS_VERSION, json_of(slot))


def read_slot(kept: KeptSlot) -> Slot | None:
    """Return what a text says; None: it is of another version."""
    slot = _read(lambda: from_plain(Slot, json.loads(kept.text)), kept.version)
    is_old = kept.version in OLDER_VERSIONS
    return replace(slot, lacks_causes=True) if slot is not None and is_old else slot


def keep_state(
    course: Course, steady: SteadyTime, seq: int, made_of: int, *, stays: bool
) -> KeptState:
    """Return the state of a course after an event as text.

    :param made_of: seq of the last event that has a say in it
    """
    assert course.now is not None
    plain = {**course.plain(), 'steady': steady.plain(seq)}
    return KeptState(seq, course.now, made_of, stays, BOOKS_VERSION, json_of(plain))


def read_state(kept: KeptState) -> Course | None:
    """Return a course that goes on from there; None: the text is of another version."""

    def read() -> Course:
        return Course.from_plain({'seq': kept.seq, **json.loads(kept.text)})

    return _read(read, kept.version)


def read_steady(kept: KeptState) -> SteadyTime | None:
    """Return what a state knows of the steps of the clock; None: it is of another version."""
    if kept.version == WITHOUT_STEPS:
        return SteadyTime(kept.seq)

    def read() -> SteadyTime:
        return SteadyTime.from_plain(json.loads(kept.text)['steady'], kept.seq)

    return _read(read, kept.version)


def keep_reason(event: OperatorDecided) -> KeptReason:
    """Return a decision that tells the reason of a stop as text."""
    return KeptReason(event.seq, to_text(event))


def keep_script(digest: str, script: Script) -> KeptScript:
    """Return a script as text."""
    return KeptScript(digest, text_of(script))


def read_script(kept: KeptScript) -> Script:
    """Return what a text says."""
    return from_plain(Script, json.loads(kept.text))


def _read(read: Callable[[], _T], version: int) -> _T | None:
    if version not in (BOOKS_VERSION, *OLDER_VERSIONS):
        return None
    try:
        return read()
    except (AssertionError, AttributeError, KeyError, TypeError, ValueError):
        return None
