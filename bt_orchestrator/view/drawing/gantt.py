"""The content of a Gantt chart: a fold over the events of a run, and the waits of its rows."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

from bt_orchestrator.model import events as e
from bt_orchestrator.model.hold_words import again_words, hold_words
from bt_orchestrator.model.task_spans import TaskSpans
from bt_orchestrator.view.report.wait_log import Waits, WaitSpan


@dataclass(frozen=True)
class TaskBar:
    """One attempt of a task."""

    key: e.TaskKey
    name: str
    component: str
    again: str
    """Round and attempt, in words; empty: the first."""
    start_s: float
    end_s: float
    outcome: str
    """succeeded, the reason of a failure, or `runs` where the chart ends first."""

    @property
    def failed(self) -> bool:
        """Tell whether the attempt came to a bad end."""
        return self.outcome not in ('succeeded', 'runs')


@dataclass(frozen=True)
class CycleBar:
    """A section's pass through its list for one item."""

    job: str
    item: str
    start_s: float
    end_s: float


@dataclass(frozen=True)
class HoldBar:
    """From a hold to its answer."""

    hold: str
    words: str
    start_s: float
    end_s: float


@dataclass
class Row:
    """One part of the cell over time."""

    title: str
    tasks: list[TaskBar] = field(default_factory=list)
    cycles: list[CycleBar] = field(default_factory=list)
    holds: list[HoldBar] = field(default_factory=list)
    waits: Sequence[WaitSpan] = ()
    forecast: Sequence[TaskBar] = ()
    """Its planned work, above its real work."""

    def lanes(self) -> list[list[TaskBar]]:
        """Return the tasks in lanes: what runs at the same time stands one below the other."""
        lanes: list[list[TaskBar]] = []
        for bar in sorted(self.tasks, key=lambda bar: (bar.start_s, bar.key.task)):
            free = (lane for lane in lanes if lane[-1].end_s <= bar.start_s)
            lane = next(free, None)
            if lane is None:
                lane = []
                lanes.append(lane)
            lane.append(bar)
        return lanes or [[]]

    def within(self, begin_s: float, end_s: float) -> Row:
        """Return what of it is in a stretch of time."""
        tasks = [bar for bar in self.tasks if bar.end_s > begin_s and bar.start_s < end_s]
        holds = [bar for bar in self.holds if bar.end_s > begin_s and bar.start_s < end_s]
        return Row(self.title, tasks, [], holds)


@dataclass(frozen=True)
class End:
    """When a job ends."""

    time_s: float
    is_forecast: bool


@dataclass(frozen=True)
class Gantt:
    """A whole chart."""

    cell: str
    total_s: float
    jobs: tuple[str, ...]
    """In the order queued."""
    rows: tuple[Row, ...]
    """Initialization, if there is any, the sections in the order of the belt, the belt; or one a
    component."""
    begin_s: float = 0.0
    """Time of its left edge: of an event, or from the begin of a virtual run."""
    is_past: bool = False
    """It is of what really happened: times are seconds since the epoch."""
    title: str = ''
    """Empty: the cell and its jobs."""
    by_component: bool = False
    """A row is a component; else a section."""
    ends: tuple[End, ...] = ()
    """Marked by a line from top to bottom."""

    def named(self, title: str) -> Gantt:
        """Return the same chart under a title."""
        return replace(self, title=title)

    def under(self, forecast: Gantt, ends: Sequence[End]) -> Gantt:
        """Return the same chart with the tasks of a forecast above those of each row."""
        rows = {row.title: row for row in self.rows}
        expected = {row.title: row.tasks for row in forecast.rows}
        titles = [*(title for title in rows if title not in expected), *expected]
        both = (
            replace(rows.get(title, Row(title)), forecast=expected.get(title, ()))
            for title in titles
        )
        jobs = tuple(dict.fromkeys([*self.jobs, *forecast.jobs]))
        return replace(self, jobs=jobs, rows=tuple(both), ends=tuple(ends))

    @property
    def items(self) -> int:
        """Count the items that were worked on."""
        worked = {bar.item for row in self.rows for bar in row.cycles}
        return len(
            worked | {bar.key.item for row in self.rows for bar in row.tasks if bar.key.item}
        )


class GanttFold:
    """Takes in one event after another. Implements `ports.EventSink`."""

    def __init__(self, *, by_component: bool = False) -> None:
        """Begin a chart.

        :param by_component: a row is a component, wherever it works; else a section
        """
        self._by_component = by_component
        self._jobs: dict[str, None] = {}
        self._spans = TaskSpans()
        self._open_cycles: dict[int, e.CycleStarted] = {}
        self._open_holds: dict[str, e.HoldRaised] = {}
        self._tasks: dict[int | str, list[TaskBar]] = defaultdict(list)
        self._cycles: dict[int, list[CycleBar]] = defaultdict(list)
        self._holds: dict[int | str, list[HoldBar]] = defaultdict(list)

    def publish(self, events: Sequence[e.Event]) -> None:
        """Take in the next events."""
        for event in events:
            self.follow(event)

    def follow(self, event: e.Event) -> None:
        """Take in the next event."""
        span = self._spans.follow(event)
        if span is not None:
            ended = span.ended
            outcome = ended.reason if isinstance(ended, e.TaskFailed) else 'succeeded'
            self._add_task(span.started, ended.time, outcome)
        elif isinstance(event, e.JobQueued):
            self._jobs[event.job] = None
        elif isinstance(event, e.CycleStarted):
            self._open_cycles[event.section] = event
        elif isinstance(event, e.CycleCompleted):
            self._end_cycle(event.section, event.time)
        elif isinstance(event, e.HoldRaised):
            self._open_holds[event.hold] = event
        elif isinstance(event, e.HoldReleased):
            self._end_hold(event.hold, event.time)

    def _add_task(self, begun: e.TaskStarted, end_s: float, outcome: str) -> None:
        again = again_words(begun.round, begun.attempt)
        place = begun.component if self._by_component else _row(begun.job, begun.section)
        self._tasks[place].append(
            TaskBar(begun.key, begun.name, begun.component, again, begun.time, end_s, outcome)
        )

    def _end_cycle(self, section: int, end_s: float) -> None:
        begun = self._open_cycles.pop(section, None)
        if begun is not None:
            self._cycles[section].append(CycleBar(begun.job, begun.item, begun.time, end_s))

    def _end_hold(self, hold: str, end_s: float) -> None:
        raised = self._open_holds.pop(hold, None)
        if raised is None:
            return
        bar = HoldBar(hold, hold_words(raised), raised.time, end_s)
        place = (
            raised.component or CELL if self._by_component else _row(raised.job, raised.section)
        )
        self._holds[place].append(bar)

    def end(self, end_s: float) -> None:
        """Let everything that has not ended go on to the end of the chart."""
        for begun in self._spans.open():
            self._add_task(begun, end_s, 'runs')
        self._spans.forget()
        for section in list(self._open_cycles):
            self._end_cycle(section, end_s)
        for hold in list(self._open_holds):
            self._end_hold(hold, end_s)

    def chart(
        self,
        cell: str,
        sections: int,
        waits: Waits,
        total_s: float,
        components: Sequence[str] = (),
    ) -> Gantt:
        """Return everything of a virtual run up to now.

        :param components: their order, where a row is a component
        """
        self.end(total_s)
        if self._by_component:
            rows = [
                self._row(name, waits.of_component(name)) for name in self._in_order(components)
            ]
        else:
            rows = list(self._rows(sections, waits))
        jobs, is_so = tuple(self._jobs), self._by_component
        return Gantt(cell, total_s, jobs, tuple(rows), by_component=is_so)

    def past(self, begin_s: float, end_s: float) -> Gantt:
        """Return what happened at each component in a stretch of time."""
        self.end(end_s)
        rows = [self._row(name, ()).within(begin_s, end_s) for name in self._in_order(())]
        rows = [row for row in rows if row.tasks or row.holds]
        keys = (bar.key for row in rows for bar in row.tasks)
        jobs = {key.job for key in keys if key.job is not None}
        order = [job for job in self._jobs if job in jobs]
        return Gantt(
            '',
            end_s - begin_s,
            (*order, *sorted(jobs - set(order))),
            tuple(rows),
            begin_s,
            is_past=True,
            by_component=True,
        )

    def _in_order(self, components: Sequence[str]) -> list[str]:
        """Return the components that worked, those of the first sections first, the belt last."""
        first = {
            name: min((bar.key.section or 0 for bar in bars if bar.key.job), default=_LAST)
            for name, bars in self._tasks.items()
        }
        first |= dict.fromkeys(self._holds.keys() - first, 0) | {CELL: -1}
        names = [name for name in first if isinstance(name, str)]
        place = {name: number for number, name in enumerate(components)}
        names.sort(key=lambda name: (place.get(name, -1), first[name], name))
        return [name for name in names if self._tasks.get(name) or self._holds.get(name)]

    def _rows(self, sections: int, waits: Waits) -> Iterator[Row]:
        if self._tasks[_INITIALIZATION]:
            yield self._row(_INITIALIZATION, waits.of_initialization)
        for number in range(1, sections + 1):
            yield self._row(number, waits.of_section(number))
        yield self._row(_BELT, waits.of_belt)

    def _row(self, place: int | str, waits: Sequence[WaitSpan]) -> Row:
        title = f'section {place}' if isinstance(place, int) else place
        cycles = self._cycles[place] if isinstance(place, int) else []
        return Row(title, self._tasks[place], cycles, self._holds[place], waits)


_INITIALIZATION, _BELT, CELL = 'initialization', 'belt', 'cell'
_LAST = 1_000_000
"""Of a component that works in no section: behind all others."""


def _row(job: str | None, section: int | None) -> int | str:
    return section or (_BELT if job is None else _INITIALIZATION)
