"""The fold from the events of a run to what they say about the line (semantics 8.3)."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import Cell, OnFailure
from bt_orchestrator.report.causes import Cause
from bt_orchestrator.report.forecast import (
    Bottleneck,
    ComponentLoad,
    Forecast,
    JobForecast,
    SectionLoad,
    WaitLoad,
    are_mix,
    at_best,
    mean_per_item_s,
    slowest_of,
    slowest_section,
    steady_interval_s,
)
from bt_orchestrator.report.intervals import Span, covered_s
from bt_orchestrator.report.turns import TurnFold
from bt_orchestrator.report.wait_log import NO_WAITS, Waits, WaitSpan


def forecast(events: Iterable[e.Event], cell: Cell) -> Forecast:
    """Fold the events of a whole run, oldest first."""
    fold = ForecastFold()
    fold.publish(list(events))
    return fold.forecast(cell)


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

    def forecast(self, bottleneck: Bottleneck | None) -> JobForecast:
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
            per_item_s=at_best(steady_interval_s(self.packed_s), bottleneck),
            bottleneck=bottleneck,
        )


class _Attempt(NamedTuple):
    start_s: float
    component: str
    section: int | None
    job: str | None


_SpansByList = defaultdict[tuple[int, str], list[Span]]
"""When tasks ran, by section and job."""


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
        self._cycles: dict[tuple[int, str], int] = defaultdict(int)
        """By section and job."""
        self._open: dict[e.TaskKey, _Attempt] = {}
        self._ended: list[tuple[_Attempt, float]] = []
        """Attempts with their ends."""
        self._turns = TurnFold()

    def publish(self, events: Sequence[e.Event]) -> None:
        """Take in the next events."""
        for event in events:
            self.follow(event)

    def follow(self, event: e.Event) -> None:
        """Take in the next event."""
        if self._first_s is None:
            self._first_s = event.time
        self._now_s = event.time - self._first_s
        self._turns.follow(event, self._now_s)
        if isinstance(event, e.TaskEvent):
            self._follow_task(event)
        elif isinstance(event, e.CycleStarted):
            self._cycles[event.section, event.job] += 1
        elif isinstance(event, e.ItemEvent):
            self._follow_item(event)
        else:
            self._follow_job(event)

    def _follow_task(self, event: e.TaskEvent) -> None:
        if isinstance(event, e.TaskStarted):
            self._open[event.key] = _Attempt(
                self._now_s, event.component, event.section, event.job
            )
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

    def forecast(self, cell: Cell, waits: Waits = NO_WAITS) -> Forecast:
        """Say what follows from the events so far; a task that still runs counts until now.

        :param waits: of the same run, if somebody looked
        """
        by_list: _SpansByList = defaultdict(list)
        by_component: dict[str, list[Span]] = defaultdict(list)
        for attempt, end_s in (*self._ended, *((one, self._now_s) for one in self._open.values())):
            span = Span(attempt.start_s, end_s)
            by_component[attempt.component].append(span)
            if attempt.section is not None and attempt.job is not None:
                by_list[attempt.section, attempt.job].append(span)
        sections = tuple(
            self._section(n, by_list, waits.of_section(n))
            for n in sorted({section for section, _ in self._cycles})
        )
        jobs = tuple(
            job.forecast(self._bottleneck_of(name, by_list)) for name, job in self._jobs.items()
        )
        return Forecast(
            total_s=self._now_s,
            per_item_s=at_best(self._per_item_s(jobs), slowest_section(sections)),
            jobs=jobs,
            sections=sections,
            components=tuple(
                _component(name, by_component[name], self._now_s, waits.of_component(name))
                for name in cell.components
            ),
        )

    def _per_item_s(self, jobs: Sequence[JobForecast]) -> float | None:
        return mean_per_item_s(jobs) if are_mix(jobs) else steady_interval_s(self._packed_s)

    def _section(
        self, number: int, by_list: _SpansByList, waits: Sequence[WaitSpan]
    ) -> SectionLoad:
        jobs = [job for section, job in self._cycles if section == number]
        spans = [span for job in jobs for span in by_list[number, job]]
        busy_s = covered_s(spans)
        return SectionLoad(
            section=number,
            cycles=sum(self._cycles[number, job] for job in jobs),
            busy_s=busy_s,
            pace_s=self._pace_s(number, jobs, spans),
            utilisation=busy_s / self._now_s if self._now_s else 0.0,
            waits=_loads(waits, self._now_s),
        )

    def _bottleneck_of(self, job: str, by_list: _SpansByList) -> Bottleneck | None:
        sections = sorted(section for section, name in self._cycles if name == job)
        return slowest_of({n: self._pace_s(n, [job], by_list[n, job]) for n in sections})

    def _pace_s(self, section: int, jobs: Sequence[str], spans: Sequence[Span]) -> float:
        """Return the seconds that a section needs for an item of some jobs."""
        cycles = sum(self._cycles[section, job] for job in jobs)
        return max(covered_s(spans) / cycles, self._turns.pace_s(section, cycles, spans))


def _component(
    name: str, spans: Sequence[Span], total_s: float, waits: Sequence[WaitSpan]
) -> ComponentLoad:
    busy_s = covered_s(spans)
    utilisation = busy_s / total_s if total_s else 0.0
    return ComponentLoad(name, len(spans), busy_s, utilisation, _loads(waits, total_s))


def _loads(spans: Sequence[WaitSpan], total_s: float) -> tuple[WaitLoad, ...]:
    """Sum up equal waits, the longest first."""
    waited_s: dict[tuple[Cause, ...], float] = defaultdict(float)
    for span in spans:
        waited_s[span.causes] += span.end_s - span.start_s
    loads = [
        WaitLoad(
            '+'.join(dict.fromkeys(cause.kind.value for cause in causes)),
            ' and '.join(cause.text for cause in causes),
            round(seconds, 9),
            seconds / total_s if total_s else 0.0,
        )
        for causes, seconds in waited_s.items()
    ]
    return tuple(sorted(loads, key=lambda load: (-load.waited_s, load.cause)))
