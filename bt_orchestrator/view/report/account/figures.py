"""OEE and its parts, with the pace in closed form: exact, to close the waterfall."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from enum import Enum
from fractions import Fraction
from typing import NamedTuple

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.proof.pace import Pace, pace
from bt_orchestrator.model.script import Script
from bt_orchestrator.view.report.account.fold import Times
from bt_orchestrator.view.report.account.losses import WORDS, Loss, Part, Step, of_step
from bt_orchestrator.view.report.account.period import MICRO_STOP_US
from bt_orchestrator.view.report.account.stops import Repairs
from bt_orchestrator.view.report.account.words import is_seen

PLANNED, BUSY, PRODUCTION, NET, VALUE = (
    'planned time',
    'planned busy time',
    'actual production time',
    'net production time',
    'value adding time',
)
"""The rest at each step of the waterfall; the first three with the names of ISO 22400."""


class Lack(Enum):
    """Why factors of the OEE are not known, although the paces are."""

    PLANNED = 'planned'
    BUSY = 'busy'
    PRODUCTION = 'production'
    PRODUCED = 'produced'


LACKS: Mapping[Lack, str] = {
    Lack.PLANNED: 'no factors and no OEE: no time of this period is planned',
    Lack.BUSY: 'no factors and no OEE: the planned busy time is 0',
    Lack.PRODUCTION: 'no performance and no quality: nothing was produced, in no production time',
    Lack.PRODUCED: 'no quality: nothing was produced',
}


class StopClass(NamedTuple):
    """Own faults of one class."""

    times: int
    us: int


class Bar(NamedTuple):
    """A step of the waterfall."""

    title: str
    us: Fraction
    """Of a loss what it takes away; below 0 where it adds."""
    loss: Loss | None = None
    """None: what is left here."""


@dataclass(frozen=True)
class Figures:
    """The figures of a period. None: not known without a pace, or nothing to divide by."""

    times: Times
    paces: Mapping[str, Pace]
    """Of the scripts that were made, by digest."""
    unpaced: tuple[str, ...]
    """Scripts that were made and have no pace."""
    micro_stop_us: int = MICRO_STOP_US
    """A shorter own fault is a micro-stop, any other a breakdown."""

    # --- quantities -------------------------------------------------------------------------

    @property
    def produced(self) -> int:
        """Produced quantity."""
        return sum(job.produced for job in self.times.made)

    @property
    def good(self) -> int:
        """Good quantity."""
        return sum(job.good for job in self.times.made)

    @property
    def first_pass(self) -> int | None:
        """Good quantity of the first pass; None: books of an older program do not know it."""
        return self.of_causes(sum(job.first_pass for job in self.times.made))

    @property
    def first_pass_yield(self) -> Fraction | None:
        """The same, of the produced quantity."""
        return None if self.first_pass is None else _ratio(self.first_pass, self.produced)

    def of_causes(self, number: int) -> int | None:
        """Return a number about causes; None: books of an older program lack a part of it."""
        return None if self.times.lacks_causes else number

    # --- times ------------------------------------------------------------------------------

    @property
    def has_paces(self) -> bool:
        """Tell whether every script that was made has a pace."""
        return not self.unpaced

    @property
    def net_us(self) -> Fraction:
        """The time for the items at the pace of their scripts."""
        return self._at_pace((job.digest, job.produced) for job in self.times.made)

    @property
    def value_us(self) -> Fraction:
        """The same for the good ones."""
        return self._at_pace((job.digest, job.good) for job in self.times.made)

    @property
    def rework_us(self) -> Fraction:
        """The price of rework: its time, as far as the performance lacks it."""
        lacking = self.times.production_us - self.net_us
        return max(Fraction(0), min(lacking, Fraction(self.times.lost_us.get(Loss.REWORK, 0))))

    def _at_pace(self, items: Iterable[tuple[str, int]]) -> Fraction:
        """Return the time of so many items of scripts, named by digest."""
        return sum(
            (self.paces[digest].limit.per_item_us * n for digest, n in items if n),
            start=Fraction(0),
        )

    # --- ratios -----------------------------------------------------------------------------

    @property
    def availability(self) -> Fraction | None:
        """Actual production time of planned busy time."""
        return _ratio(self.times.production_us, self.times.busy_us)

    @property
    def performance(self) -> Fraction | None:
        """Effectiveness: what was made, at the pace, of the actual production time."""
        return _ratio(self.net_us, self.times.production_us) if self.has_paces else None

    @property
    def quality(self) -> Fraction | None:
        """Good quantity of produced quantity, each item with the weight of its pace."""
        if self.has_paces and self.net_us:
            return _ratio(self.value_us, self.net_us)
        return _ratio(self.good, self.produced)

    @property
    def oee(self) -> Fraction | None:
        """Overall equipment effectiveness."""
        return _ratio(self.value_us, self.times.busy_us) if self.has_paces else None

    @property
    def lack(self) -> Lack | None:
        """Why a factor has nothing to divide by; None: each has."""
        if not self.times.planned.total_us:
            return Lack.PLANNED
        if not self.times.busy_us:
            return Lack.BUSY
        if self.produced:
            return None
        return Lack.PRODUCED if self.times.production_us else Lack.PRODUCTION

    @property
    def per_item_us(self) -> Fraction | None:
        """Actual production time of one item."""
        return _ratio(self.times.production_us, self.produced)

    @property
    def pace_us(self) -> Fraction | None:
        """The time for one item at the pace; of several scripts the mean."""
        return _ratio(self.net_us, self.produced) if self.has_paces else None

    # --- classes and parts of stops -----------------------------------------------------------

    def breakdowns(self, component: str | None = None) -> StopClass:
        """Return the own faults that are as long as a breakdown.

        :param component: that they are of; None: all
        """
        faults_us = [
            us
            for name, faults in self.times.long_faults.items()
            if component in (None, name)
            for us in faults
            if us >= self.micro_stop_us
        ]
        return StopClass(len(faults_us), sum(faults_us))

    def micro_stops(self, component: str | None = None) -> StopClass:
        """Return all other own faults."""
        stops = [
            stop
            for stop in self.times.stops
            if stop.loss is Loss.OWN_FAULT and component in (None, stop.component)
        ]
        longer = self.breakdowns(component)
        times, us = sum(stop.times for stop in stops), sum(stop.us for stop in stops)
        return StopClass(times - longer.times, us - longer.us)

    def part_us(self, part: Part) -> int | None:
        """Return the time of a part of a loss; None: books of an older program lack it."""
        return self.of_causes(sum(stop.us for stop in self.times.stops if stop.part is part))

    # --- components -------------------------------------------------------------------------

    def mtbf_us(self, repairs: Repairs) -> Fraction | None:
        """Return the mean operating time between failures."""
        operated = self.of_causes(self.times.operated_us.get(repairs.component, 0))
        return None if operated is None else Fraction(operated, repairs.failures)

    def mttr_us(self, repairs: Repairs) -> Fraction:
        """Return the mean time to repair: that which is booked to its holds."""
        return Fraction(repairs.repair_us, repairs.failures)

    # --- the waterfall ----------------------------------------------------------------------

    def waterfall(self) -> Iterator[Bar]:
        """Yield what is left at each step, and what is lost before the next one.

        Without paces it ends with the actual production time.
        """
        times = self.times
        yield Bar(PLANNED, Fraction(times.planned.total_us))
        yield from self._losses(Step.NOT_BUSY)
        yield Bar(BUSY, Fraction(times.busy_us))
        yield from self._losses(Step.AVAILABILITY)
        yield Bar(PRODUCTION, Fraction(times.production_us))
        if not self.has_paces:
            return
        yield from self._losses(Step.PERFORMANCE)
        yield Bar(NET, self.net_us)
        yield from self._losses(Step.QUALITY)
        yield Bar(VALUE, self.value_us)

    def of_stops(self, us: int) -> Fraction | None:
        """Return the share of the time of all stops that are long enough to have a reason."""
        return _ratio(us, sum(reason.us for reason in self.times.by_reason))

    @property
    def not_classified(self) -> Fraction | None:
        """The share of the stops that have no reason, by their time."""
        return self.of_stops(sum(reason.us for reason in self.times.by_reason if not reason.code))

    def of_planned(self, us: Fraction | int) -> Fraction | None:
        """Return the share of the planned time."""
        return _ratio(us, self.times.planned.total_us)

    def steps_seen(self) -> Iterator[Bar]:
        """Yield the waterfall without losses that are written as 0.0 s."""
        return (bar for bar in self.waterfall() if bar.loss is None or is_seen(bar.us))

    def loss_us(self, loss: Loss) -> Fraction:
        """Return what a loss takes away."""
        if loss is Loss.REWORK:
            return self.rework_us
        if loss is Loss.SLOW:
            return self.times.production_us - self.rework_us - self.net_us
        if loss is Loss.REJECTS:
            return self.net_us - self.value_us
        return Fraction(self.times.lost_us.get(loss, 0))

    def _losses(self, step: Step) -> Iterator[Bar]:
        for loss in of_step(step):
            us = self.loss_us(loss)
            if us:
                yield Bar(WORDS[loss].title, us, loss)


class Paces:
    """The paces of scripts by the durations of a cell, each worked out once."""

    def __init__(self, cell: Cell | None) -> None:
        """Begin.

        :param cell: None: there are none
        """
        self.cell = cell
        self._known: dict[str, Pace | None] = {}

    def of(self, digest: str, script: Script) -> Pace | None:
        """Return the pace of a script; None: it is for another cell, or the line gets stuck."""
        if digest not in self._known:
            self._known[digest] = None if self.cell is None else _pace(script, self.cell)
        return self._known[digest]


def figures(times: Times, paces: Paces, micro_stop_us: int = MICRO_STOP_US) -> Figures:
    """Return the figures of a period.

    :param micro_stop_us: a shorter own fault is a micro-stop
    """
    by_digest = {digest: paces.of(digest, script) for digest, script in times.scripts.items()}
    known = {digest: line_pace for digest, line_pace in by_digest.items() if line_pace is not None}
    unpaced = {job.script or job.job: job.digest for job in times.made if job.produced}
    lacking = tuple(name for name, key in unpaced.items() if key not in known)
    return Figures(times, known, lacking, micro_stop_us)


def _pace(script: Script, cell: Cell) -> Pace | None:
    needed = {task.component for task in script.tasks.values()}
    return pace(script, cell) if needed <= cell.components.keys() else None


def _ratio(part: Fraction | int, whole: Fraction | int) -> Fraction | None:
    return Fraction(part) / whole if whole else None
