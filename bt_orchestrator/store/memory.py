"""A journal in memory: for virtual runs, and for real ones that need not survive."""

from __future__ import annotations

from collections.abc import Sequence
from uuid import uuid4

from bt_orchestrator.model.events import Event
from bt_orchestrator.ports import Snapshot


class MemoryStore:
    """Keeps events in a list. Implements `ports.EventStore`."""

    def __init__(self, history: str | None = None) -> None:
        """Begin a journal.

        :param history: its name where nothing may be random, as in a virtual run
        """
        self._history = uuid4().hex if history is None else history
        self._events: list[Event] = []

    @property
    def history(self) -> str:
        """Return the name that no other journal has."""
        return self._history

    @property
    def is_restored(self) -> bool:
        """Return False: there are no copies of it."""
        return False

    def missing(self, after: int) -> str:  # noqa: ARG002 - the port's
        """Return nothing: what is in memory is whole."""
        return ''

    def go_on_after(self, seq: int) -> None:
        """Do nothing: nothing is ever missing."""

    def append(self, events: Sequence[Event]) -> None:
        """Keep the events."""
        self._events.extend(events)

    def read(self, after: int = 0, most: int = -1) -> Sequence[Event]:
        """Return the events with a seq greater than `after`; seq counts from 1 without gaps."""
        return self._events[after:] if most < 0 else self._events[after : after + most]

    def first_seq(self) -> int:
        """Return 1: nothing is ever removed."""
        return 1

    def snapshots(self) -> Sequence[Snapshot]:
        """Return no state: nobody starts from here again who had to hurry."""
        return ()

    def beginning(self) -> None:
        """Return no state: replay begins with the first event of all."""
