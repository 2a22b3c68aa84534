"""How long tasks really take here: what the nominal durations of a cell file cannot know."""

from __future__ import annotations

import statistics
from collections import defaultdict, deque
from collections.abc import Mapping, Sequence

from bt_orchestrator.model import events as e

KEPT = 9
"""So many durations of each task are remembered, the last ones."""


class ObservedDurations:
    """Remembers how long successful attempts took. Implements `ports.EventSink`."""

    def __init__(self) -> None:
        self._started: dict[e.TaskKey, e.TaskStarted] = {}
        self._took_s: dict[tuple[str, str], deque[float]] = defaultdict(lambda: deque(maxlen=KEPT))

    def publish(self, events: Sequence[e.Event]) -> None:
        """Take in the next events."""
        for event in events:
            if isinstance(event, e.TaskStarted):
                self._started[event.key] = event
            elif isinstance(event, e.TaskSucceeded):
                self._succeeded(event)
            elif isinstance(event, e.TaskFailed):
                self._started.pop(event.key, None)

    def seconds(self) -> Mapping[str, Mapping[str, float]]:
        """Return the usual seconds of each task seen, by component and task constant."""
        found: dict[str, dict[str, float]] = defaultdict(dict)
        for (component, name), took_s in self._took_s.items():
            found[component][name] = statistics.median(took_s)
        return found

    def _succeeded(self, event: e.TaskSucceeded) -> None:
        begun = self._started.pop(event.key, None)
        if begun is not None:
            self._took_s[begun.component, begun.name].append(event.time - begun.time)
