"""News from the gateways for the tick: goals, state readings and contests, oldest first."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from bt_orchestrator.model.goal import (
    SafetyReading,
    SeenContest,
    SetupReading,
    StateReading,
)
from bt_orchestrator.ports import Told

_READINGS = (StateReading, SetupReading, SeenContest, SafetyReading)


class News:
    """The queue behind `ActionGateway.drain`.

    A goal that was accepted and ended between two drains is listed once, at the place of the later
    news: the goal object shows both.
    """

    def __init__(self) -> None:
        self._entries: dict[int, Told] = {}
        self._wake: Callable[[], None] = _ignore

    def listen(self, wake: Callable[[], None]) -> None:
        """Set the function to call when news with consequences is added."""
        self._wake = wake

    def add(self, entry: Told) -> None:
        """Add news; an acceptance does not wake the tick: its record can wait for the next one."""
        # By identity: two equal state readings are two readings, and values may be unhashable.
        self._entries.pop(id(entry), None)
        self._entries[id(entry)] = entry
        if isinstance(entry, _READINGS) or entry.end is not None:
            self._wake()

    def drain(self) -> Sequence[Told]:
        """Return what was added since the last call."""
        entries, self._entries = self._entries, {}
        return tuple(entries.values())


def _ignore() -> None:
    """Placeholder until a wake function is set."""
