"""The sum of the slots of a period; some slots are planned time."""

from __future__ import annotations

import heapq
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from bt_orchestrator.model.script import Script
from bt_orchestrator.view.report.account.causes.flaws import Bounds, Flaw, FlawSum, MeasuredSum
from bt_orchestrator.view.report.account.causes.made import Made, add
from bt_orchestrator.view.report.account.losses import WORDS, Loss, Part, Step, is_stop
from bt_orchestrator.view.report.account.planned import Planned
from bt_orchestrator.view.report.account.slot import RestOfHolds, Slot, StopSum
from bt_orchestrator.view.report.account.stops import (
    MOST_HOLDS,
    FailingTask,
    Held,
    Repairs,
    Stop,
    without_times,
)
from bt_orchestrator.view.report.line_stops import (
    GivenReasons,
    LineStop,
    ReasonSum,
    SpanTotal,
)


@dataclass(frozen=True)
class Times:
    """Where the time of a period went, as far as events alone can tell."""

    planned: Planned
    producing_us: int
    """Without rework."""
    lost_us: dict[Loss, int]
    """`rework` is as it was measured: time in which something was done again."""
    made: tuple[Made, ...]
    scripts: dict[str, Script]
    """Those that were made, by digest, as far as the journal has them."""
    stops: tuple[Stop, ...]
    holds: tuple[Held, ...]
    holds_left_out: int
    left_out_us: dict[Loss, int]
    failing: tuple[FailingTask, ...]
    repairs: tuple[Repairs, ...]
    flaws: tuple[FlawSum, ...]
    """Causes of scrap and rework, the most frequent first."""
    measured: tuple[MeasuredSum, ...]
    operated_us: dict[str, int]
    """Time in which each component operated."""
    cell: str
    """Name of the cell; empty: not known."""
    cells: tuple[str, ...]
    """Digests of the cell files that the node ran with in this time; empty: not known."""
    lacks_causes: bool = False
    """A part of it is from books of an older program, without causes and times of work."""
    line_stops: tuple[LineStop, ...] = ()
    """The longest stops one by one, in their order."""
    by_reason: tuple[ReasonSum, ...] = ()
    """All that are long enough, added up by reason, loss and cause."""
    long_faults: Mapping[str, Sequence[int]] = field(default_factory=dict)
    """By component, the planned time of each own fault that may be a breakdown."""

    @property
    def line_stops_count(self) -> int:
        """How many stops there were that are long enough for the list."""
        return sum(reason.times for reason in self.by_reason)

    @property
    def line_stops_us(self) -> int:
        """Their planned time."""
        return sum(reason.us for reason in self.by_reason)

    @property
    def short_stops_us(self) -> int:
        """Time of stops that are too short, or too many, for the list."""
        stops_us = sum(stop.us for stop in self.stops if is_stop(stop.loss))
        return stops_us - self.line_stops_us

    def step_us(self, *steps: Step) -> int:
        """Return the time lost in some steps."""
        return sum(us for loss, us in self.lost_us.items() if WORDS[loss].step in steps)

    @property
    def busy_us(self) -> int:
        """Planned busy time."""
        return self.planned.total_us - self.step_us(Step.NOT_BUSY)

    @property
    def production_us(self) -> int:
        """Actual production time: with rework."""
        return self.busy_us - self.step_us(Step.AVAILABILITY)


class Total:
    """Takes in one slot after another, oldest first; each is planned, or is not."""

    def __init__(self, reasons: GivenReasons | None = None) -> None:
        """Begin.

        :param reasons: of the stops; None: they have none but those that are in the slots
        """
        self._spans = SpanTotal(reasons or GivenReasons())
        self._producing = 0
        self._stops: dict[tuple[Loss, str, str, Part], StopSum] = {}
        self._has_counted = False
        """The stop that stands at the end of the last slot is counted."""
        self._open: dict[str, Held] = {}
        self._told: list[tuple[int, int, int, Held]] = []
        self._number = 0
        self._left_out_count = 0
        self._left_out: Counter[Loss] = Counter()
        self._counted: set[str] = set()
        """Holds that are among the failures of their components."""
        self._repairs: dict[str, Repairs] = {}
        self._made: dict[tuple[str, str], Made] = {}
        self._failures: Counter[tuple[str, str, str]] = Counter()
        self._took: Counter[tuple[str, str, str]] = Counter()
        self._flaws: Counter[Flaw] = Counter()
        self._measured: dict[Bounds, MeasuredSum] = {}
        self._operated: Counter[str] = Counter()
        self._lacks_causes = False
        self._cell = ''
        self._cells: dict[str, None] = {}

    @property
    def made(self) -> tuple[Made, ...]:
        """The jobs whose items left the line, the first first."""
        return tuple(replace(job) for job in self._made.values())

    def add(self, slot: Slot, *, is_planned: bool) -> None:
        """Take in the next slot."""
        self._cell = slot.cell or self._cell
        self._cells.update(dict.fromkeys(slot.cells))
        for made in slot.made:
            nothing = Made(made.job, made.script, made.digest, made.recipe, made.recipe_version)
            so_far = self._made.setdefault((made.job, made.digest), nothing)
            add(so_far, made, is_planned=is_planned)
        for held in slot.holds:
            self._hold(held, is_planned=is_planned)
        self._spans.add(slot, is_planned=is_planned)
        if is_planned:
            self._add_times(slot)
        elif not slot.is_one_stop:
            self._has_counted = False

    def _add_times(self, slot: Slot) -> None:
        self._lacks_causes |= slot.lacks_causes
        self._producing += slot.producing_us
        for stop in slot.stops:
            new = StopSum(stop.loss, stop.detail, stop.component, part=stop.part)
            known = self._stops.setdefault(new.key, new)
            known.us += stop.us
            known.begun += stop.begun + (stop.goes_on and not self._has_counted)
        self._has_counted = True
        for failed in slot.failed:
            task = (failed.component, failed.task, failed.reason)
            self._failures[task] += failed.times
            self._took[task] += failed.us
        for rest in slot.rest:
            self._add_rest(rest)
        self._operated.update(slot.operated_us)
        for flaw in slot.flaws:
            self._flaws[flaw.of] += flaw.times
        for measured in slot.measured:
            known_sum = self._measured.get(measured.of)
            if known_sum is None:
                self._measured[measured.of] = replace(measured)
            else:
                known_sum.add(measured)

    def _add_rest(self, rest: RestOfHolds) -> None:
        self._left_out_count += rest.told
        if rest.loss is not None:
            self._left_out[rest.loss] += rest.lost_us
        if rest.failures:
            repairs = self._repairs.setdefault(rest.component, Repairs(rest.component))
            repairs.failures += rest.failures
            repairs.down_us += rest.down_us
            repairs.repair_us += rest.lost_us

    # --- holds --------------------------------------------------------------------------------

    def _hold(self, held: Held, *, is_planned: bool) -> None:
        known = self._open.get(held.hold)
        if known is None:
            known = self._open[held.hold] = without_times(held)
        known.told_as(held)
        if is_planned:
            known.loss = held.loss or known.loss
            known.stood_us += held.stood_us
            known.lost_us += held.lost_us
            if held.component and (held.fails or held.down_us):
                self._failed(held)
        if held.released_us is not None:
            self._keep(self._open.pop(held.hold))
            self._counted.discard(held.hold)

    def _failed(self, held: Held) -> None:
        repairs = self._repairs.setdefault(held.component, Repairs(held.component))
        repairs.down_us += held.down_us
        repairs.repair_us += held.lost_us
        if held.hold not in self._counted:
            self._counted.add(held.hold)
            repairs.failures += 1

    def _keep(self, held: Held) -> None:
        if not held.stood_us:
            return
        self._number += 1
        entry = (held.lost_us, held.stood_us, -self._number, held)
        if len(self._told) < MOST_HOLDS:
            heapq.heappush(self._told, entry)
            return
        left = heapq.heappushpop(self._told, entry)[3]
        self._left_out_count += 1
        if left.loss is not None:
            self._left_out[left.loss] += left.lost_us

    # --- the sum ------------------------------------------------------------------------------

    def times(self, planned: Planned, scripts: dict[str, Script]) -> Times:
        """Return the sum; no further slot is taken in after that.

        :param planned: the time of the slots that were planned
        :param scripts: those of the jobs that were made
        """
        for held in self._open.values():
            self._keep(held)
        lost: Counter[Loss] = Counter()
        for stop in self._stops.values():
            lost[stop.loss] += stop.us
        return Times(
            planned,
            self._producing,
            {loss: us for loss in Loss if (us := lost[loss])},
            self.made,
            scripts,
            self._sorted_stops(),
            tuple(sorted((entry[3] for entry in self._told), key=lambda held: held.raised_us)),
            self._left_out_count,
            dict(self._left_out),
            self._failing(),
            tuple(
                sorted(
                    self._repairs.values(), key=lambda record: (-record.down_us, record.component)
                )
            ),
            self._sorted_flaws(),
            tuple(sorted(self._measured.values(), key=lambda record: record.of.order)),
            {name: us for name, us in sorted(self._operated.items()) if us},
            self._cell,
            tuple(self._cells),
            self._lacks_causes,
            *self._spans.stops(),
        )

    def _sorted_stops(self) -> tuple[Stop, ...]:
        """Return the stops, the longest first."""
        stops = (
            Stop(stop.loss, stop.detail, stop.component, stop.begun, stop.us, stop.part)
            for stop in self._stops.values()
        )
        return tuple(
            sorted(
                stops, key=lambda stop: (-stop.us, stop.loss.value, *stop[1:3], stop.part.value)
            )
        )

    def _failing(self) -> tuple[FailingTask, ...]:
        """Return the tasks that failed, the most frequent first."""
        failures = (FailingTask(*key, n, self._took[key]) for key, n in self._failures.items())
        return tuple(
            sorted(failures, key=lambda failure: (-failure.times, -failure.us, failure[:3]))
        )

    def _sorted_flaws(self) -> tuple[FlawSum, ...]:
        flaws = (FlawSum(flaw, n) for flaw, n in self._flaws.items())
        return tuple(sorted(flaws, key=lambda flaw: (-flaw.times, flaw.of.order)))
