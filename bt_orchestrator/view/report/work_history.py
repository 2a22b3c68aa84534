"""The last cycles of a section, or work of a component: attempts, failures, times."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from bt_orchestrator.model import events as e
from bt_orchestrator.model.task_spans import TaskSpan, TaskSpans
from bt_orchestrator.view.report.item.history import FAILED, RUNNING, SUCCEEDED

MOST_CYCLES = 20
MOST_FAILURES = 50
MOST_TIMES = 20
"""The last ones are kept."""

WORKS, WAITS, RESTS = 'works', 'waits', 'rests'
"""A goal is in flight; a cycle is in hand and none is; neither."""

FOLLOWED = (
    'task.started',
    'task.succeeded',
    'task.failed',
    'cycle.',
    'component.state_changed',
    e.ClockStepped.event,
)


class Attempt(NamedTuple):
    """One attempt."""

    task: str
    name: str
    component: str
    section: int | None
    item: str
    attempt: int
    started: float
    ended: float | None
    seconds: float | None
    outcome: str
    reason: str
    message: str


@dataclass
class Cycle:
    """One pass of a section through its list, or what a component did for one item."""

    item: str
    job: str
    started: float
    ended: float | None = None
    seconds: float | None = None
    tasks: list[Attempt] = field(default_factory=list)


class WorkFold:
    """Takes in events, in order. Of a section, or of a component: the other one is None."""

    def __init__(self, section: int | None = None, component: str | None = None) -> None:
        self.section = section
        self.component = component
        self.cycles: deque[Cycle] = deque(maxlen=MOST_CYCLES)
        self.failures: deque[Attempt] = deque(maxlen=MOST_FAILURES)
        self._times: dict[tuple[str, str], deque[float]] = {}
        """By component and task constant."""
        self._spans = TaskSpans()
        self._time_in: dict[str, float] = {}
        self._state = RESTS
        self._since: float | None = None
        self._reported = ''

    def follow(self, event: e.Event) -> None:
        """Take in the next event; what is not about it changes nothing."""
        if isinstance(event, e.ClockStepped):
            self._clock_set(event)
        if self._since is None:
            self._since = event.time
        if isinstance(event, e.CycleEvent):
            if event.section == self.section:
                self._cycle(event)
        elif isinstance(event, e.ComponentStateChanged):
            if event.component == self.component:
                self._pass_time(event.time)
                self._reported = '' if event.value is None else str(event.value)
        elif isinstance(event, e.TaskEvent) and self._is_mine(event):
            self._task(event)

    def until(self, time: float) -> None:
        """Let time pass up to a moment."""
        self._pass_time(max(time, self._since or time))

    @property
    def time_in(self) -> Mapping[str, float]:
        """Seconds in each state."""
        return self._time_in

    @property
    def times(self) -> Mapping[tuple[str, str], Sequence[float]]:
        """Seconds of the last attempts that succeeded, oldest first."""
        return self._times

    # --- folds ------------------------------------------------------------------------------

    def _is_mine(self, event: e.TaskEvent) -> bool:
        if self.section is not None:
            return event.section == self.section
        if isinstance(event, e.TaskStarted):
            return event.component == self.component
        return self._spans.start_of(event) is not None

    def _clock_set(self, event: e.ClockStepped) -> None:
        """Give what goes on the time that the new clock would have shown at its begin."""
        if self._since is not None:
            self._since += event.seconds
        self._spans.follow(event)
        if self.cycles and (self.cycles[-1].ended is None or self.component is not None):
            cycle = self.cycles[-1]
            cycle.started += event.seconds
            cycle.ended = None if cycle.ended is None else cycle.ended + event.seconds

    def _cycle(self, event: e.CycleEvent) -> None:
        self._pass_time(event.time)
        if isinstance(event, e.CycleStarted):
            self.cycles.append(Cycle(event.item, event.job, event.time))
        elif isinstance(event, e.CycleCompleted) and self.cycles:
            _close(self.cycles[-1], event.time)
        self._look()

    def _task(self, event: e.TaskEvent) -> None:
        self._pass_time(event.time)
        span = self._spans.follow(event)
        if isinstance(event, e.TaskStarted) and self.component is not None:
            self._begin_work(event)
        if span is not None:
            self._ended(span)
        self._look()

    def _begin_work(self, event: e.TaskStarted) -> None:
        """A component has no cycles: what it does for one item without another between is one."""
        subject, last = event.item or '', self.cycles[-1] if self.cycles else None
        if last is None or (last.item, last.job) != (subject, event.job or ''):
            self.cycles.append(Cycle(subject, event.job or '', event.time))

    def _ended(self, span: TaskSpan) -> None:
        attempt = _attempt(span)
        if self.cycles and self.cycles[-1].started <= span.started.time:
            self.cycles[-1].tasks.append(attempt)
            if self.component is not None:
                _close(self.cycles[-1], span.ended.time)
        if attempt.outcome == FAILED:
            self.failures.append(attempt)
        else:
            key = (span.started.component, span.started.name)
            self._times.setdefault(key, deque(maxlen=MOST_TIMES)).append(span.seconds)

    # --- time -------------------------------------------------------------------------------

    def _look(self) -> None:
        has_cycle = bool(self.cycles) and self.cycles[-1].ended is None
        self._state = (
            WORKS
            if any(True for _ in self._spans.open())
            else (WAITS if has_cycle and self.section is not None else RESTS)
        )

    def _pass_time(self, now: float) -> None:
        since, self._since = self._since, now
        if since is None or now <= since:
            return
        reported = f', {self._reported}' if self._reported else ''
        state = f'{self._state}{reported}'
        self._time_in[state] = self._time_in.get(state, 0.0) + now - since

    def in_flight(self) -> list[Attempt]:
        """Return the attempts that have not ended."""
        return [
            Attempt(
                span.task, span.name, span.component, span.section, span.item or '', span.attempt,
                span.time, None, None, RUNNING, '', '',
            )
            for span in self._spans.open()
        ]  # fmt: skip


def _close(cycle: Cycle, time: float) -> None:
    cycle.ended, cycle.seconds = time, time - cycle.started


def _attempt(span: TaskSpan) -> Attempt:
    start, end = span.started, span.ended
    has_failed = isinstance(end, e.TaskFailed)
    return Attempt(
        start.task,
        start.name,
        start.component,
        start.section,
        start.item or '',
        start.attempt,
        start.time,
        end.time,
        span.seconds,
        FAILED if has_failed else SUCCEEDED,
        end.reason if isinstance(end, e.TaskFailed) else '',
        end.message if isinstance(end, e.TaskFailed) else '',
    )
