"""Measured durations of tasks, in place of the nominal ones of the cell file."""

from __future__ import annotations

import logging
import statistics
from collections import defaultdict, deque
from collections.abc import Mapping, Sequence
from dataclasses import replace

from bt_orchestrator.base.errors import DamagedRecord
from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.task_spans import TaskSpan, TaskSpans
from bt_orchestrator.ports import EventStore

log = logging.getLogger(__name__)

KEPT = 9
"""Number of durations kept of each task, the latest ones."""

EVENTS_READ = 1000
"""Number of the last events of a journal that a node reads for durations at its start."""


def last_events(store: EventStore, last: int) -> Sequence[e.Event]:
    """Return the last events for the durations; no state depends on them.

    :param last: the last event of the journal
    """
    after = max(0, last - EVENTS_READ)
    while True:
        try:
            return list(store.read(after))
        except DamagedRecord as damage:
            log.warning('%s: how long tasks take is learned from the events after it', damage)
            after = damage.last


class ObservedDurations:
    """Remembers how long successful attempts took. Implements `ports.EventSink`."""

    def __init__(self) -> None:
        self._spans = TaskSpans()
        self._took_s: dict[tuple[str, str], deque[float]] = defaultdict(lambda: deque(maxlen=KEPT))
        self._usual_s: dict[tuple[str, str], float] = {}
        """Cache of the medians of `_took_s`."""

    def publish(self, events: Sequence[e.Event]) -> None:
        """Take in the next events."""
        for event in events:
            span = self._spans.follow(event)
            if span is not None:
                self._learn(span)
            elif isinstance(event, (e.OrchestratorStarted, e.ClockStepped)):
                # It is unknown when within the pause it ended, or the clock is another one.
                self._spans.forget()

    @property
    def kinds(self) -> int:
        """Number of different tasks seen, counted per component."""
        return len(self._took_s)

    def seconds(self) -> Mapping[str, Mapping[str, float]]:
        """Return the usual seconds of each task seen, by component and task constant."""
        durations_s: dict[str, dict[str, float]] = defaultdict(dict)
        for (component, name), took_s in self._took_s.items():
            durations_s[component][name] = statistics.median(took_s)
        return durations_s

    def usual_s(self, component: str, name: str) -> float | None:
        """Return the usual seconds of a task; None: it was not seen."""
        kind = component, name
        if kind not in self._usual_s and kind in self._took_s:
            self._usual_s[kind] = statistics.median(self._took_s[kind])
        return self._usual_s.get(kind)

    def _learn(self, span: TaskSpan) -> None:
        is_sound = span.seconds >= 0.0  # or the wall clock was set back
        if is_sound and isinstance(span.ended, e.TaskSucceeded):
            kind = span.started.component, span.started.name
            self._took_s[kind].append(span.seconds)
            self._usual_s.pop(kind, None)


def as_observed(cell: Cell, observed_s: Mapping[str, Mapping[str, float]]) -> Cell:
    """Return the cell with the durations that were seen.

    Nominal durations of tasks not seen yet are scaled by the median ratio of the others. A
    component that only an older cell file has is ignored.
    """
    ratios = [
        took_s / nominal_s
        for name, component in cell.components.items()
        for task, took_s in observed_s.get(name, {}).items()
        if (nominal_s := component.duration_s(task))
    ]
    factor = statistics.median(ratios) if ratios else 1.0
    components = {
        name: replace(
            component,
            durations_s={task: factor * s for task, s in component.durations_s.items()}
            | dict(observed_s.get(name, {})),
            default_duration_s=factor * component.default_duration_s,
        )
        for name, component in cell.components.items()
    }
    conveyor = replace(cell.conveyor, component=components[cell.conveyor.component.name])
    return replace(cell, conveyor=conveyor, components=components)
