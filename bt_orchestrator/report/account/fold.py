"""The fold from events to the account of a period: every moment of planned time is booked once."""

from __future__ import annotations

from copy import deepcopy

from bt_orchestrator.model import events as e
from bt_orchestrator.model.script import Script
from bt_orchestrator.report.account.course import FOLLOWED, Course
from bt_orchestrator.report.account.planned import Planned
from bt_orchestrator.report.account.slot import Slot
from bt_orchestrator.report.account.slots import Slots
from bt_orchestrator.report.account.standing import Cause
from bt_orchestrator.report.account.total import Times, Total

__all__ = ['FOLLOWED', 'AccountFold', 'Times']


class AccountFold:
    """Takes in one event after another, oldest first."""

    def __init__(self, planned: Planned, *, is_whole: bool) -> None:
        """Begin.

        :param is_whole: the first event that comes is the first of all
        """
        self._planned = planned
        borders = [moment for piece in planned.pieces for moment in piece]
        self._begin = borders[0] if borders else 0
        self._course = Course(is_whole=is_whole, begin=self._begin)
        self._slots = Slots(self._course.holds, self._add, self._begin, borders)
        self._total = Total()
        self._scripts: dict[str, Script] = {}

    @property
    def cause(self) -> Cause | None:
        """What the time is lost to since the last event; None: the line produces."""
        return self._course.cause

    def follow(self, event: e.Event) -> None:
        """Take in the next event."""
        self._course.follow(event, self._slots)
        if isinstance(event, e.ScriptLoaded):
            self._scripts[event.digest] = event.definition

    def until(self, end: int) -> Times:
        """Return the account as far as a moment, from which no event has come yet.

        It may be asked at any time: the fold goes on from its last event. What a moment was lost
        to may come out later; a node that was killed says nothing before it starts again.
        """
        total = deepcopy(self._total)
        for slot in self._slots.until(self._course.rest(end)):
            total.add(slot, is_planned=self._planned.includes(slot.until_us))
        used = {one.digest for one in total.made}
        scripts = {digest: one for digest, one in self._scripts.items() if digest in used}
        return total.times(self._planned.before(end), scripts)

    def _add(self, slot: Slot) -> None:
        self._total.add(slot, is_planned=self._planned.includes(slot.until_us))
