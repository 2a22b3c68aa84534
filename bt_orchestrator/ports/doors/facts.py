"""The news of a cell, in order."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from bt_orchestrator.model.codec import to_text
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.status import CellStatus


@dataclass(frozen=True)
class Began:
    """A history, and the event after which its events follow."""

    history: str
    last: int


class Happened:
    """An event, with its record as JSON once somebody reads it."""

    def __init__(self, event: Event) -> None:
        self.first = self.last = event.seq
        self.event = event

    @cached_property
    def text(self) -> str:
        """The record."""
        return to_text(self.event)


class Lost:
    """Events that are lost for good: removed from the journal, or damaged."""

    def __init__(self, first: int, last: int) -> None:
        self.first = first
        self.last = last


Fact = Began | Happened | Lost | CellStatus
