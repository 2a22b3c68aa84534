"""The account of one stretch of time: sums that can be added up, whatever of it is planned."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from bt_orchestrator.view.report.account.causes.flaws import FlawSum, MeasuredSum
from bt_orchestrator.view.report.account.causes.made import Made
from bt_orchestrator.view.report.account.losses import Loss, Part
from bt_orchestrator.view.report.account.planned import US
from bt_orchestrator.view.report.account.stops import Held

QUARTER_US = 15 * 60 * US
"""Slots end at quarters of an hour since the epoch: in every time zone an hour is four of them."""

LEAST_STOP_US = US // 20
"""A shorter one is no stop by itself: the node needs such moments between two tasks."""

LEAST_BREAKDOWN_US = 10 * US
"""A shorter own fault is a micro-stop. Those that no slot tells one by one are shorter: in each
quarter of an hour a hundred others are at least as long."""

MOST_SPANS = 100
"""Stops that a slot tells one by one, besides those that go beyond it: the longest."""


@dataclass
class StopSum:
    """Time that was lost to one cause."""

    loss: Loss
    detail: str = ''
    component: str = ''
    begun: int = 0
    """How often the line stopped for it in this stretch."""
    us: int = 0
    goes_on: bool = False
    """The stretch begins with such a stop that had begun before."""
    part: Part = Part.WHOLE

    @property
    def key(self) -> tuple[Loss, str, str, Part]:
        """The cause."""
        return self.loss, self.detail, self.component, self.part


@dataclass
class StopSpan:
    """A stop of the line, or a part of it: one span of time with one loss and one cause."""

    seq: int
    """Of the event with which it began; with the history it is the name of the stop."""
    loss: Loss
    detail: str = ''
    component: str = ''
    hold: str = ''
    """The hold that it waited for; empty: none."""
    part: Part = Part.WHOLE
    since_us: int = 0
    """When it began, also where that was before the slot."""
    until_us: int = 0
    code: str = ''
    """Of the reason that was given with the pause, the stop or what else caused it."""

    @property
    def long_us(self) -> int:
        """How long it is, from its begin."""
        return self.until_us - self.since_us


@dataclass
class FailedSum:
    """Attempts of a task that failed for one reason."""

    component: str = ''
    task: str = ''
    reason: str = ''
    times: int = 0
    us: int = 0


@dataclass
class RestOfHolds:
    """Holds of one kind that are not told one by one."""

    loss: Loss | None = None
    """None: their time is booked to older holds."""
    component: str = ''
    """The component that failed; empty: none."""
    told: int = 0
    """How many of them stood for a while."""
    lost_us: int = 0
    failures: int = 0
    down_us: int = 0


@dataclass(frozen=True)
class Slot:
    """The events from one moment to another. An event at the end belongs to it."""

    begin_us: int
    until_us: int
    producing_us: int = 0
    stops: tuple[StopSum, ...] = ()
    holds: tuple[Held, ...] = ()
    """Those that stood, with the time of this stretch alone; those that ended in it come first."""
    rest: tuple[RestOfHolds, ...] = ()
    made: tuple[Made, ...] = ()
    failed: tuple[FailedSum, ...] = ()
    flaws: tuple[FlawSum, ...] = ()
    measured: tuple[MeasuredSum, ...] = ()
    operated_us: Mapping[str, int] = field(default_factory=dict)
    """Time in which components operated."""
    cell: str = ''
    cells: tuple[str, ...] = ()
    """Digests of the cell files with which the node ran in it."""
    is_steady: bool = False
    """All of it has one cause, and nothing else happened: each part of it is as the whole."""
    spans: tuple[StopSpan, ...] = ()
    """Its stops one by one, in their order: those of `LEAST_STOP_US`, and of many the longest."""
    lacks_causes: bool = False
    """It is of an older program: causes of scrap and rework and times of work are not in it."""

    @property
    def is_one_stop(self) -> bool:
        """Tell whether the line stood all the time for what had stopped it before."""
        return not self.producing_us and [(stop.begun, stop.goes_on) for stop in self.stops] == [
            (0, True)
        ]

    def part(self, begin: int, until: int) -> Slot:
        """Return a part of a steady slot."""
        assert self.is_steady
        begin, until = max(begin, self.begin_us), min(until, self.until_us)
        us, whole = until - begin, self.until_us - self.begin_us
        is_first = begin == self.begin_us
        stops = (
            piece if is_first else replace(piece, begun=0, goes_on=True)
            for piece in (replace(stop, us=us) for stop in self.stops)
        )
        holds = (
            replace(
                hold,
                stood_us=us if hold.stood_us == whole else 0,
                lost_us=us if hold.lost_us == whole else 0,
                down_us=us if hold.down_us == whole else 0,
            )
            for hold in self.holds
        )
        return replace(
            self,
            begin_us=begin,
            until_us=until,
            producing_us=us if self.producing_us else 0,
            stops=tuple(stops),
            holds=tuple(holds),
            spans=tuple(replace(span, until_us=until) for span in self.spans),
            operated_us=dict.fromkeys(self.operated_us, us),
        )
