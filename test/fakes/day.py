"""A journal written by hand: events at times of the clock of one day, in UTC."""

from __future__ import annotations

from datetime import date, datetime, timezone

from bt_orchestrator.model import events as e
from bt_orchestrator.store.memory import MemoryRecords, MemoryStore

DATE = '2026-05-18'
"""A Monday."""


def at(clock: str) -> float:
    """Return a time of the day, as 06:00 or 06:00:01.5."""
    moment = datetime.fromisoformat(f'{DATE}T{_whole(clock)}')
    return moment.replace(tzinfo=timezone.utc).timestamp()


class Day:
    """Takes in events in the order of their times."""

    def __init__(self, first_seq: int = 1) -> None:
        self.events: list[e.Event] = []
        self._first_seq = first_seq

    @staticmethod
    def date() -> date:
        """Return the day."""
        return date.fromisoformat(DATE)

    def note(self, clock: str | float, *events: e.Event) -> None:
        """Record events at a time of the clock, or at seconds since the epoch."""
        time = at(clock) if isinstance(clock, str) else clock
        for event in events:
            self.events.append(event.stamped(self._first_seq + len(self.events), time))

    def records(self) -> MemoryRecords:
        """Return the journal; it is of a history `day`."""
        store = MemoryStore('day')
        store.append(self.events)
        return MemoryRecords(store)


def _whole(clock: str) -> str:
    return clock if clock.count(':') == 2 else f'{clock}:00'
