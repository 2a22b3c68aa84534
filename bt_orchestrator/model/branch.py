"""A behaviour tree as data: each behaviour's status, and its children."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum


class Outcome(IntEnum):
    """The status of a behaviour after its last tick; INVALID: it was not ticked."""

    INVALID = 1
    RUNNING = 2
    SUCCESS = 3
    FAILURE = 4

    @property
    def word(self) -> str:
        """The outcome for a person."""
        return self.name.lower()


@dataclass(frozen=True)
class Branch:
    """A behaviour with its children."""

    name: str
    status: Outcome
    words: str
    """Its feedback message."""
    is_decorator: bool
    children: tuple[Branch, ...]
