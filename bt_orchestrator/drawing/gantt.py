"""The content of a Gantt chart: a fold over the events of a run, and the waits of its rows."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from bt_orchestrator.model import events as e
from bt_orchestrator.model.hold_words import again_words, hold_words
from bt_orchestrator.report.task_spans import TaskSpans
from bt_orchestrator.report.wait_log import Waits, WaitSpan


@dataclass(frozen=True)
class TaskBar:
    """One attempt of a task."""

    key: e.TaskKey
    name: str
    component: str
    again: str
    """Which round and attempt, in words; empty: the first."""
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

    def lanes(self) -> list[list[TaskBar]]:
        """Return the tasks in lanes: what runs at the same time stands one below the other."""
        found: list[list[TaskBar]] = []
        for bar in sorted(self.tasks, key=lambda bar: (bar.start_s, bar.key.task)):
            free = (lane for lane in found if lane[-1].end_s <= bar.start_s)
            lane = next(free, None)
            if lane is None:
                lane = []
                found.append(lane)
            lane.append(bar)
        return found or [[]]


@dataclass(frozen=True)
class Gantt:
    """A whole chart."""

    cell: str
    total_s: float
    jobs: tuple[str, ...]
    """In the order queued."""
    rows: tuple[Row, ...]
    """Initialization, if there is any, the sections in the order of the belt, the belt."""

    @property
    def items(self) -> int:
        """Count the items that were worked on."""
        return len({bar.item for row in self.rows for bar in row.cycles})


class GanttFold:
    """Takes in one event after another. Implements `ports.EventSink`."""

    def __init__(self) -> None:
        self._jobs: list[str] = []
        self._spans = TaskSpans()
        self._open_cycles: dict[int, e.CycleStarted] = {}
        self._open_holds: dict[str, e.HoldRaised] = {}
        self._tasks: dict[int | str, list[TaskBar]] = defaultdict(list)
        self._cycles: dict[int, list[CycleBar]] = defaultdict(list)
        self._holds: dict[int | str, list[HoldBar]] = defaultdict(list)

    def publish(self, events: Sequence[e.Event]) -> None:
        """Take in the next events."""
        for event in events:
            self._follow(event)

    def _follow(self, event: e.Event) -> None:
        span = self._spans.follow(event)
        if span is not None:
            ended = span.ended
            outcome = ended.reason if isinstance(ended, e.TaskFailed) else 'succeeded'
            self._add_task(span.started, ended.time, outcome)
        elif isinstance(event, e.JobQueued):
            self._jobs.append(event.job)
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
        self._tasks[_row(begun.job, begun.section)].append(
            TaskBar(begun.key, begun.name, begun.component, again, begun.time, end_s, outcome)
        )

    def _end_cycle(self, section: int, end_s: float) -> None:
        begun = self._open_cycles.pop(section)
        self._cycles[section].append(CycleBar(begun.job, begun.item, begun.time, end_s))

    def _end_hold(self, hold: str, end_s: float) -> None:
        raised = self._open_holds.pop(hold)
        bar = HoldBar(hold, hold_words(raised), raised.time, end_s)
        self._holds[_row(raised.job, raised.section)].append(bar)

    def chart(self, cell: str, sections: int, waits: Waits, total_s: float) -> Gantt:
        """Return everything up to now; what has not ended goes on to the end of the chart."""
        for begun in self._spans.open():
            self._add_task(begun, total_s, 'runs')
        self._spans.forget()
        for section in list(self._open_cycles):
            self._end_cycle(section, total_s)
        for hold in list(self._open_holds):
            self._end_hold(hold, total_s)
        rows = tuple(self._rows(sections, waits))
        return Gantt(cell, total_s, tuple(self._jobs), rows)

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


_INITIALIZATION, _BELT = 'initialization', 'belt'


def _row(job: str | None, section: int | None) -> int | str:
    return section or (_BELT if job is None else _INITIALIZATION)
