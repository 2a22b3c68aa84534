"""Steady time: the time of a node's clock without the steps by which the clock was set.

Steady time begins as the time of the clock. From each step on the clock is ahead of it, or behind.
It never goes back, so durations and sums of time use it; people are told the time of the clock.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any, NamedTuple, TypeVar

from bt_orchestrator.model import events as e
from bt_orchestrator.view.report.account.planned import US, us_of

_FAR_US = 1 << 62

_E = TypeVar('_E', bound=e.Event)

STEPS = (e.ClockStepped.event, e.OrchestratorStarted.event)
"""Names of the events with which the clock may be another one."""


class Step(NamedTuple):
    """The clock was set."""

    seq: int
    """The first event with the new time."""
    at_us: int
    """When, in steady time."""
    by_us: int
    """By how much, forward; negative: back."""
    ahead_us: int
    """How far the clock is ahead of steady time from then on."""

    @property
    def times_us(self) -> tuple[int, int]:
        """The time that the clock showed before, and after."""
        after = self.at_us + self.ahead_us
        return after - self.by_us, after


class SteadyTime:
    """Knows the steps of a clock, and takes in further events in their order.

    A clock that is behind when a node starts was set back meanwhile, by that much at least.
    """

    def __init__(
        self, since: int = 0, steps: Iterable[Sequence[int]] = (), ahead_us: int = 0
    ) -> None:
        """Begin.

        :param since: steps up to this event are not taken out
        :param steps: those that are known
        :param ahead_us: how far the clock is ahead before the first step
        """
        self._ahead_us = ahead_us
        self.since = self.known = since
        """Steps up to this event are known."""
        self.steps = [Step(*step) for step in steps]
        self._wall: int | None = None
        """The clock's time at the last event that was taken in."""
        self._wall_before: int | None = None
        """The same at the event before that."""

    def follow(self, event: e.Event) -> None:
        """Take in an event, if it is a new one."""
        if event.seq > self.known:
            wall = us_of(event.time)
            by = self._step_us(event, wall)
            if by:
                ahead = self.steps[-1].ahead_us if self.steps else self._ahead_us
                at = max(wall - by - ahead, self.steps[-1].at_us if self.steps else -_FAR_US)
                self.steps.append(Step(event.seq, at, by, wall - at))
            self.known, self._wall, self._wall_before = event.seq, wall, self._wall

    def of(self, event: _E) -> _E:
        """Take in an event, and return it with steady time; a step is none any more."""
        if event.seq > self.known:
            self.follow(event)
        ahead = self.ahead_of(event.seq) if self.steps else self._ahead_us
        if isinstance(event, e.ClockStepped) and event.seq > self.since:
            event = replace(event, seconds=0.0)
        elif isinstance(event, e.TaskRetrying) and ahead:
            event = replace(event, not_before=event.not_before - ahead / US)
        return event.stamped(event.seq, (us_of(event.time) - ahead) / US) if ahead else event

    def us(self, event: e.Event) -> int:
        """Return when an event was that was taken in."""
        return us_of(event.time) - self.ahead_of(event.seq)

    def ahead_of(self, seq: int) -> int:
        """Return how far the clock was ahead at an event."""
        at = bisect_right(self.steps, seq, key=lambda step: step.seq)
        return self.steps[at - 1].ahead_us if at else self._ahead_us

    def ahead_at(self, moment: int) -> int:
        """Return how far the clock was ahead from a moment on."""
        at = bisect_right(self.steps, moment, key=lambda step: step.at_us)
        return self.steps[at - 1].ahead_us if at else self._ahead_us

    def clock_us(self, moment: int) -> int:
        """Return what the clock showed at a moment; where it was set: its new time."""
        return moment + self.ahead_at(moment)

    def step_after(self, moment: int) -> int:
        """Return when the clock was set next after a moment."""
        at = bisect_right(self.steps, moment, key=lambda step: step.at_us)
        return self.steps[at].at_us if at < len(self.steps) else _FAR_US

    def within(self, begin: int, end: int) -> Sequence[Step]:
        """Return the steps between two moments, both included."""
        first = bisect_left(self.steps, begin, key=lambda step: step.at_us)
        return self.steps[first : bisect_right(self.steps, end, key=lambda step: step.at_us)]

    def clock_span(self, begin: int, end: int) -> tuple[int, int]:
        """Return the earliest and the latest time that the clock showed between two moments."""
        shown = [self.clock_us(begin), self.clock_us(end)]
        for step in self.within(begin, end):
            shown += step.times_us
        return min(shown), max(shown)

    def latest_clock_us(self, seq: int, moment: int) -> int:
        """Return the latest time that the clock showed from an event until a moment."""
        steps = [step for step in self.steps if step.seq > seq and step.at_us <= moment]
        return max(self.clock_us(moment), *(max(step.times_us) for step in steps), -_FAR_US)

    def when_shown(self, pieces: Iterable[tuple[int, int]]) -> list[tuple[int, int]]:
        """Return when the clock showed a time in some pieces: in order, what came twice twice."""
        pieces = list(pieces)
        aheads = [self._ahead_us, *(step.ahead_us for step in self.steps)]
        borders = [-_FAR_US, *(step.at_us for step in self.steps), _FAR_US]
        intervals = (
            (max(begin - ahead, since), min(end - ahead, until))
            for ahead, (since, until) in zip(aheads, pairwise(borders), strict=True)
            for begin, end in pieces
        )
        return [interval for interval in intervals if interval[0] < interval[1]]

    def as_shown_at(self, moment: int) -> SteadyTime:
        """Return the same steps in the time that goes on as the clock did at a moment."""
        ahead = self.ahead_at(moment)
        steps = [
            step._replace(at_us=step.at_us + ahead, ahead_us=step.ahead_us - ahead)
            for step in self.steps
        ]
        steady_time = SteadyTime(self.since, steps, self._ahead_us - ahead)
        steady_time.known = _FAR_US
        return steady_time

    def up_to(self, seq: int) -> SteadyTime:
        """Return the known steps up to an event, after which there are no others."""
        steps = (step for step in self.steps if step.seq <= seq)
        steady_time = SteadyTime(self.since, steps, self._ahead_us)
        steady_time.known = _FAR_US
        return steady_time

    def _step_us(self, event: e.Event, wall: int) -> int:
        """Return by how much the clock was set before an event."""
        if isinstance(event, e.ClockStepped):
            return us_of(event.seconds)
        if isinstance(event, e.OrchestratorStarted) and self._wall is not None:
            return wall - self._wall if wall <= self._wall - US else 0
        return 0

    # --- kept and gone on from ----------------------------------------------------------------

    def plain(self, seq: int) -> dict[str, Any]:
        """Return what it knew after an event, the last one or that before it, for JSON."""
        wall = self._wall if self.known <= seq else self._wall_before
        steps = [step for step in self.steps if step.seq <= seq]
        return {'since': self.since, 'wall': wall, 'steps': steps}

    @classmethod
    def from_plain(cls, plain: dict[str, Any], seq: int) -> SteadyTime:
        """Return what another one knew after an event."""
        made = cls(plain['since'], plain['steps'])
        made.known, made._wall = seq, plain['wall']
        return made
