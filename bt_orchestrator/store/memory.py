"""A journal in memory: for virtual runs, and for real ones that need not survive."""

from __future__ import annotations

from collections.abc import Sequence

from bt_orchestrator.model.events import Event


class MemoryStore:
    """Keeps events in a list. Implements `ports.EventStore`."""

    def __init__(self) -> None:
        self._events: list[Event] = []

    def append(self, events: Sequence[Event]) -> None:
        """Keep the events."""
        self._events.extend(events)

    def read(self, after: int = 0) -> Sequence[Event]:
        """Return the events with a seq greater than `after`; seq counts from 1 without gaps."""
        return self._events[after:]
