"""What a run says about the line: a fold over its events (semantics 8.3)."""

from __future__ import annotations

import itertools
import statistics
from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import Cell, OnFailure
from bt_orchestrator.sim.intervals import Span, covered_s


@dataclass(frozen=True)
class JobForecast:
    """How one job goes."""

    job: str
    script: str
    quantity: int
    packed: int = 0
    rejected: int = 0
    """Rejected items that left the line."""
    missing: int = 0
    """Never placed, or taken off the belt by hand."""
    nonconforming: int = 0
    started_s: float | None = None
    finished_s: float | None = None
    """Both from the first event on. None: it had not come to that when the events ended."""
    aborted: bool = False
    per_item_s: float | None = None
    """In steady state; None with fewer than two items packed."""


@dataclass(frozen=True)
class SectionLoad:
    """How long a section works on its items."""

    section: int
    cycles: int
    busy_s: float
    """Seconds in which at least one of its tasks ran, initialization left out."""

    @property
    def busy_per_cycle_s(self) -> float:
        """Seconds of work for one item."""
        return self.busy_s / self.cycles if self.cycles else 0.0


@dataclass(frozen=True)
class ComponentLoad:
    """How long a component works."""

    component: str
    tasks: int
    """Attempts, failed ones included."""
    busy_s: float
    utilisation: float
    """Busy time as a part of the total, 0 to 1."""


@dataclass(frozen=True)
class Forecast:
    """What a run says; of a run that did not end, up to its last event."""

    total_s: float
    """From the first event to the last."""
    per_item_s: float | None
    """Seconds between two packed items in steady state, all jobs together."""
    jobs: tuple[JobForecast, ...]
    """In the order queued."""
    sections: tuple[SectionLoad, ...]
    """Those that had cycles, in the order of the belt."""
    components: tuple[ComponentLoad, ...]
    """All of the cell, in the order of its file."""

    @property
    def bottleneck(self) -> SectionLoad | None:
        """The section that needs most time for an item; of equals the first."""
        return max(self.sections, key=lambda load: load.busy_per_cycle_s, default=None)


def forecast(events: Iterable[e.Event], cell: Cell) -> Forecast:
    """Fold the events of a whole run, oldest first."""
    fold = ForecastFold()
    fold.publish(list(events))
    return fold.forecast(cell)


def steady_interval_s(times_s: Sequence[float]) -> float | None:
    """Return the median interval in the middle half: a line that fills or drains is not steady."""
    intervals = [later - earlier for earlier, later in itertools.pairwise(times_s)]
    edge = len(intervals) // 4
    middle = intervals[edge : len(intervals) - edge]
    return statistics.median(middle) if middle else None


@dataclass
class _Job:
    queued: e.JobQueued
    started_s: float | None = None
    finished_s: float | None = None
    aborted: bool = False
    packed_s: list[float] = field(default_factory=list)
    rejected: int = 0
    missing: int = 0
    nonconforming: set[str] = field(default_factory=set)

    def forecast(self) -> JobForecast:
        return JobForecast(
            job=self.queued.job,
            script=self.queued.script,
            quantity=self.queued.quantity,
            packed=len(self.packed_s),
            rejected=self.rejected,
            missing=self.missing,
            nonconforming=len(self.nonconforming),
            started_s=self.started_s,
            finished_s=self.finished_s,
            aborted=self.aborted,
            per_item_s=steady_interval_s(self.packed_s),
        )


class _Attempt(NamedTuple):
    start_s: float
    component: str
    section: int | None


class ForecastFold:
    """Takes in one event after another. Implements `ports.EventSink`.

    `forecast` may be asked at any time.
    """

    def __init__(self) -> None:
        self._first_s: float | None = None
        self._now_s = 0.0
        """Seconds since the first event; so are all times here."""
        self._jobs: dict[str, _Job] = {}
        self._packed_s: list[float] = []
        self._cycles: dict[int, int] = defaultdict(int)
        self._open: dict[e.TaskKey, _Attempt] = {}
        self._ended: list[tuple[_Attempt, float]] = []
        """Attempts with their ends."""

    def publish(self, events: Sequence[e.Event]) -> None:
        """Take in the next events."""
        for event in events:
            self.follow(event)

    def follow(self, event: e.Event) -> None:
        """Take in the next event."""
        if self._first_s is None:
            self._first_s = event.time
        self._now_s = event.time - self._first_s
        if isinstance(event, e.TaskEvent):
            self._follow_task(event)
        elif isinstance(event, e.CycleStarted):
            self._cycles[event.section] += 1
        elif isinstance(event, e.ItemEvent):
            self._follow_item(event)
        else:
            self._follow_job(event)

    def _follow_task(self, event: e.TaskEvent) -> None:
        if isinstance(event, e.TaskStarted):
            self._open[event.key] = _Attempt(self._now_s, event.component, event.section)
        elif isinstance(event, (e.TaskSucceeded, e.TaskFailed)):
            attempt = self._open.pop(event.key, None)
            if attempt is not None:  # a task may fail without having been sent
                self._ended.append((attempt, self._now_s))
        elif isinstance(event, e.TaskContinued):
            self._follow_continued(event)

    def _follow_continued(self, event: e.TaskContinued) -> None:
        if event.job is None or event.item is None:
            return
        if event.policy == OnFailure.CONTINUE.value:
            self._jobs[event.job].nonconforming.add(event.item)

    def _follow_item(self, event: e.ItemEvent) -> None:
        job = self._jobs[event.job]
        if isinstance(event, e.ItemMissing):
            job.missing += 1
        elif isinstance(event, e.ItemRemoved):
            if event.how == 'packed':
                job.packed_s.append(self._now_s)
                self._packed_s.append(self._now_s)
            elif event.how == 'rejected':
                job.rejected += 1
            else:
                job.missing += 1

    def _follow_job(self, event: e.Event) -> None:
        if isinstance(event, e.JobQueued):
            self._jobs[event.job] = _Job(event)
        elif isinstance(event, e.JobStarted):
            self._jobs[event.job].started_s = self._now_s
        elif isinstance(event, (e.JobCompleted, e.JobAborted)):
            self._jobs[event.job].finished_s = self._now_s
            self._jobs[event.job].aborted = isinstance(event, e.JobAborted)

    def forecast(self, cell: Cell) -> Forecast:
        """Say what follows from the events so far; a task that still runs counts until now."""
        running = [(attempt, self._now_s) for attempt in self._open.values()]
        by_section: dict[int, list[Span]] = defaultdict(list)
        by_component: dict[str, list[Span]] = defaultdict(list)
        for attempt, end_s in (*self._ended, *running):
            span = Span(attempt.start_s, end_s)
            by_component[attempt.component].append(span)
            if attempt.section is not None:
                by_section[attempt.section].append(span)
        return Forecast(
            total_s=self._now_s,
            per_item_s=steady_interval_s(self._packed_s),
            jobs=tuple(job.forecast() for job in self._jobs.values()),
            sections=tuple(
                SectionLoad(n, self._cycles[n], covered_s(by_section[n]))
                for n in sorted(self._cycles)
            ),
            components=tuple(
                _load(name, by_component[name], self._now_s) for name in cell.components
            ),
        )


def _load(component: str, spans: Sequence[Span], total_s: float) -> ComponentLoad:
    busy_s = covered_s(spans)
    return ComponentLoad(component, len(spans), busy_s, busy_s / total_s if total_s else 0.0)
