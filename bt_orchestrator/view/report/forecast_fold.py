"""The fold from the events of a run to its figures (semantics 8.3)."""

from __future__ import annotations

import statistics
from collections import defaultdict
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.jobs.counting import PACKED
from bt_orchestrator.model.jobs.job_record import ABORTED, REMOVED, JobRecord
from bt_orchestrator.model.task_spans import TaskSpans
from bt_orchestrator.view.report.ended_jobs import JobFold
from bt_orchestrator.view.report.forecast import (
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
from bt_orchestrator.view.report.intervals import Span, common, covered_s
from bt_orchestrator.view.report.wait_log import (
    NO_WAITS,
    Cause,
    Waits,
    WaitSpan,
    cause_words,
    kind_words,
)


def forecast(events: Iterable[e.Event], cell: Cell) -> Forecast:
    """Fold the events of a whole run, oldest first."""
    fold = ForecastFold()
    fold.publish(list(events))
    return fold.forecast(cell)


class _Attempt(NamedTuple):
    span: Span
    component: str
    name: str
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
        self._jobs = JobFold()
        self._cycles: dict[tuple[int, str], int] = defaultdict(int)
        """By section and job."""
        self._tasks = TaskSpans()
        self._ended: list[_Attempt] = []
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
        self._jobs.follow(event)
        task = self._tasks.follow(event)
        if task is not None:
            self._ended.append(self._attempt(task.started, self._now_s))
        elif isinstance(event, e.CycleStarted):
            self._cycles[event.section, event.job] += 1

    def _attempt(self, started: e.TaskStarted, end_s: float) -> _Attempt:
        span = Span(self._since_first(started.time), end_s)
        return _Attempt(span, started.component, started.name, started.section, started.job)

    def _since_first(self, time: float) -> float:
        return time - (self._first_s or 0.0)

    def forecast(self, cell: Cell, waits: Waits = NO_WAITS) -> Forecast:
        """Return the figures from the events so far; a running task counts until now.

        :param waits: of the same run, if they were recorded
        """
        by_list: _SpansByList = defaultdict(list)
        by_component: dict[str, list[Span]] = defaultdict(list)
        runs = [self._attempt(started, self._now_s) for started in self._tasks.open()]
        for attempt in (*self._ended, *runs):
            by_component[attempt.component].append(attempt.span)
            if attempt.section is not None and attempt.job is not None:
                by_list[attempt.section, attempt.job].append(attempt.span)
        sections = tuple(
            self._section(n, by_list, waits.of_section(n))
            for n in sorted({section for section, _ in self._cycles})
        )
        jobs = tuple(
            self._job(job, self._bottleneck_of(job.job, by_list))
            for job in self._jobs.jobs.values()
        )
        return Forecast(
            total_s=self._now_s,
            per_item_s=at_best(self._per_item_s(jobs), slowest_section(sections)),
            jobs=jobs,
            sections=sections,
            changeover_s=_changeover_s((*self._ended, *runs), cell),
            components=tuple(
                _component(name, by_component[name], self._now_s, waits.of_component(name))
                for name in cell.components
            ),
        )

    def _job(self, job: JobRecord, bottleneck: Bottleneck | None) -> JobForecast:
        counts = job.counts
        finished = None if job.status == REMOVED else job.ended
        return JobForecast(
            job=job.job,
            script=job.script,
            quantity=job.quantity,
            packed=counts.packed,
            rejected=counts.rejected,
            missing=counts.missing,
            nonconforming=counts.nonconforming,
            started_s=None if job.started is None else self._since_first(job.started),
            finished_s=None if finished is None else self._since_first(finished),
            aborted=job.status == ABORTED,
            per_item_s=at_best(steady_interval_s(self._packed_s([job])), bottleneck),
            bottleneck=bottleneck,
        )

    def _packed_s(self, jobs: Iterable[JobRecord]) -> Sequence[float]:
        """Return when items of some jobs were packed, in order."""
        items = (item for job in jobs for item in job.items.values())
        return sorted(
            self._since_first(item.ended)
            for item in items
            if item.how == PACKED and item.ended is not None
        )

    def _per_item_s(self, jobs: Sequence[JobForecast]) -> float | None:
        if are_mix(jobs):
            return mean_per_item_s(jobs)
        return steady_interval_s(self._packed_s(self._jobs.jobs.values()))

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


def _changeover_s(attempts: Iterable[_Attempt], cell: Cell) -> float:
    """Return the seconds of changes of setups before the first task of a job (semantics 5.3)."""
    changes = {
        (name, setup.task)
        for name, component in cell.components.items()
        for setup in component.setups.values()
    }
    return sum(
        attempt.span.end - attempt.span.start
        for attempt in attempts
        if attempt.section is None and (attempt.component, attempt.name) in changes
    )


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
            kind_words(causes),
            cause_words(causes),
            round(seconds, 9),
            seconds / total_s if total_s else 0.0,
        )
        for causes, seconds in waited_s.items()
    ]
    return tuple(sorted(loads, key=lambda load: (-load.waited_s, load.cause)))


# The fold that measures how long each section keeps the belt at rest.


class TurnFold:
    """Follows when each section owes its turn: its beat has come and it is not complete (3.4)."""

    def __init__(self) -> None:
        self._beat = 1
        self._open: dict[int, tuple[int, float]] = {}
        """Beat of the turn that a section has begun, and since when it keeps the belt."""
        self._owed: dict[int, list[Span]] = defaultdict(list)
        self._first: dict[int, list[Span]] = defaultdict(list)
        """The same, before the belt has moved at all."""
        self._has_moved = False
        self._move_began_s: float | None = None
        self._moves_s: list[float] = []

    def follow(self, event: e.Event, now_s: float) -> None:
        """Take in the next event."""
        if isinstance(event, e.CycleStarted):
            self._open[event.section] = (event.beat, now_s)
        elif isinstance(event, e.TurnCompleted):
            self._complete(event.section, now_s)
        elif isinstance(event, e.BeltIndexStarted):
            self._move_began_s = now_s
            self._has_moved = True
        elif isinstance(event, (e.BeltIndexed, e.BeatStarted)):
            self._begin_beat(event.beat, now_s)

    def pace_s(self, section: int, cycles: int, worked: Sequence[Span]) -> float:
        """Return the seconds that a section needs for one of some cycles if it never waits.

        The belt is kept for as long as its work in the turn lasts, and then moves; steps that run
        while the belt moves cost nothing here. Turns before the first move are left out where
        there are others: the source could do nothing ahead of them.

        :param worked: when the tasks of these cycles ran
        """
        first = sum(any(common(worked, [span])) for span in self._first[section])
        owed = self._owed[section]
        if first == cycles:
            first, owed = 0, self._first[section]
        move_s = statistics.median(self._moves_s) if self._moves_s else 0.0
        return covered_s(common(worked, owed)) / (cycles - first) + move_s

    def _complete(self, section: int, now_s: float) -> None:
        beat, since_s = self._open.pop(section)
        if beat <= self._beat:
            owed = self._owed if self._has_moved else self._first
            owed[section].append(Span(since_s, now_s))

    def _begin_beat(self, beat: int, now_s: float) -> None:
        self._beat = beat
        if self._move_began_s is not None:
            self._moves_s.append(now_s - self._move_began_s)
            self._move_began_s = None
        for section, (turn, _) in self._open.items():
            if turn == beat:  # begun ahead, while the belt moved: no wait
                self._open[section] = (turn, now_s)
