"""The fold that keeps how long each task took, by day or by hour, in bounded memory."""

from __future__ import annotations

from array import array
from collections import defaultdict
from collections.abc import Mapping
from datetime import datetime, tzinfo
from typing import NamedTuple

from bt_orchestrator.model import events as e
from bt_orchestrator.model.task_spans import TaskSpan, TaskSpans

MOST_KEPT = 200
"""Durations of one task that are kept of a day or an hour, evenly over it."""

FOLLOWED = (
    e.TaskStarted.event,
    e.TaskSucceeded.event,
    e.TaskFailed.event,
    e.OrchestratorStarted.event,
    e.ClockStepped.event,
)
"""Names of the events that it needs."""


class Kind(NamedTuple):
    """A task of a component."""

    component: str
    name: str
    """Task constant."""

    def __str__(self) -> str:
        return f'{self.component} {self.name}'


class Samples:
    """Durations of one stretch of time: all of them, or every second, every fourth and so on."""

    def __init__(self) -> None:
        self.seconds = array('d')
        self.count = 0
        """How many there were, those that are not kept included."""
        self._every = 1

    def add(self, seconds: float) -> None:
        """Take in one more."""
        if self.count % self._every == 0:
            self.seconds.append(seconds)
        self.count += 1
        if len(self.seconds) > MOST_KEPT:
            self.seconds = self.seconds[::2]
            self._every *= 2


Buckets = Mapping[datetime, Samples]
"""By the beginning of the day or hour, in order."""


class TimesFold:
    """Takes in one event after another. Only attempts that succeeded count."""

    def __init__(self, zone: tzinfo | None, *, by_hour: bool = False) -> None:
        self._zone = zone
        self._by_hour = by_hour
        self._spans = TaskSpans()
        self.kinds: dict[Kind, dict[datetime, Samples]] = defaultdict(dict)

    def follow(self, event: e.Event) -> None:
        """Take in the next event."""
        span = self._spans.follow(event)
        if span is not None:
            self._learn(span)
        elif isinstance(event, (e.OrchestratorStarted, e.ClockStepped)):
            # It is unknown when within the pause it ended, or the clock is another one.
            self._spans.forget()

    def _learn(self, span: TaskSpan) -> None:
        if not isinstance(span.ended, e.TaskSucceeded) or span.seconds < 0.0:
            return
        begun = datetime.fromtimestamp(span.started.time, self._zone)
        hour = begun.hour if self._by_hour else 0
        bucket = begun.replace(hour=hour, minute=0, second=0, microsecond=0)
        kind = Kind(span.started.component, span.started.name)
        self.kinds[kind].setdefault(bucket, Samples()).add(span.seconds)
