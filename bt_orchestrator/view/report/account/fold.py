"""The fold from events to the account of a period: every moment of planned time is booked once."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from typing import NamedTuple

from bt_orchestrator.model import events as e
from bt_orchestrator.model.script import Script
from bt_orchestrator.view.report.account.course import FOLLOWED, Course
from bt_orchestrator.view.report.account.planned import Planned
from bt_orchestrator.view.report.account.slot import Slot
from bt_orchestrator.view.report.account.slots import Slots
from bt_orchestrator.view.report.account.standing import Cause
from bt_orchestrator.view.report.account.steady_time import SteadyTime
from bt_orchestrator.view.report.account.total import Times, Total

__all__ = ['FOLLOWED', 'AccountFold', 'Times']


class FromBooks(NamedTuple):
    """The part of an account that comes from books."""

    span: tuple[int, ...] = ()
    """From when to when there were slots; empty: there were none."""
    rounded: tuple[int, ...] = ()
    """Begins of slots that planned time covers in part, and whose events are gone."""
    seqs: tuple[int, ...] = ()
    """First and last of the events that were read where slots do not suffice; empty: none was."""


class Begun(NamedTuple):
    """The first part of an account, taken in elsewhere."""

    course: Course
    total: Total
    until_us: int
    """Up to when slots were taken in."""
    last: Slot | None
    """The newest of them, if it is not in the total yet."""
    books: FromBooks
    find: Callable[[str], Script | None]
    """Finds scripts by digest that no event has told of."""
    steady: SteadyTime
    """Of the slots."""


class AccountFold:
    """Takes in one event after another, oldest first, all in steady time."""

    def __init__(
        self, planned: Planned, *, is_whole: bool = False, begun: Begun | None = None
    ) -> None:
        """Begin.

        :param is_whole: the first event that comes is the first of all
        :param begun: where to go on; None: with the first planned moment
        """
        borders = [moment for piece in planned.pieces for moment in piece]
        if begun is None:
            begin = borders[0] if borders else 0
            course = Course(is_whole=is_whole, begin=begin)
            begun = Begun(course, Total(), begin, None, FromBooks(), lambda _: None, SteadyTime())
        self._planned = planned
        self._course, self._total, self._begin, last, self.books, self._find, steady = begun
        self._slots = Slots(self._course.holds, self._add, self._begin, borders, steady=steady)
        self._slots.runs(self._course.cell, self._course.digest)
        if last is not None:
            self._slots.go_on_from(last)
        self._scripts: dict[str, Script | None] = {}

    @property
    def cause(self) -> Cause | None:
        """The loss since the last event; None: the line produces."""
        return self._course.cause

    @property
    def since_us(self) -> int:
        """From when on that is so."""
        return self._course.since

    @property
    def name(self) -> int:
        """The number of the event with which that began."""
        return self._course.name

    @property
    def has_begun(self) -> bool:
        """Tell whether an event has come; what was before the first one is not recorded."""
        return self._course.now is not None

    @property
    def begun_us(self) -> int:
        """Up to when slots of books were taken in; else the first planned moment."""
        return self._begin

    def follow(self, event: e.Event) -> None:
        """Take in the next event."""
        self._course.follow(event, self._slots)
        if isinstance(event, e.ScriptLoaded):
            self._scripts[event.digest] = event.definition

    def comes_after(self, event: e.Event, end: int) -> None:
        """Let the time pass up to a moment, after which an event comes that says what it was."""
        if self._course.now is not None:
            self._course.pass_until(event, self._slots, end)

    def until(self, end: int) -> Times:
        """Return the account as far as a moment, from which no event has come yet.

        It may be asked at any time: the fold goes on from its last event. What a moment was lost
        to may come out later; a node that was killed says nothing before it starts again.
        """
        total = deepcopy(self._total)
        for slot in self._slots.until(self._course.rest(end)):
            total.add(slot, is_planned=self._planned.includes(slot.until_us))
        used = (self._script(job.digest) for job in total.made)
        return total.times(self._planned.before(max(end, self._begin)), dict(filter(None, used)))

    def _script(self, digest: str) -> tuple[str, Script] | None:
        if digest and digest not in self._scripts:
            self._scripts[digest] = self._find(digest)
        script = self._scripts.get(digest)
        return None if script is None else (digest, script)

    def _add(self, slot: Slot) -> None:
        self._total.add(slot, is_planned=self._planned.includes(slot.until_us))
