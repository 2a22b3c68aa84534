"""The state of a line at work as a drawing shows it, for tasks, slots, flags and sections."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum


class Mark(Enum):
    """The state of a task; sign and word show it without colours."""

    NEW = ('', '', '')
    WAITING = ('\u2026', 'waits', '#fff4cc')
    RUNNING = ('\u25b6', 'running', '#cfe3ff')
    FAILED = ('\u21bb', 'failed, is tried again', '#ffe0cc')
    HELD = ('!', 'HELD', '#ffd0d0')
    DONE = ('\u2713', 'done', '#d7f2de')
    MARKED_DONE = ('\u2713', 'marked done', '#d7f2de')
    SKIPPED = ('\u21b7', 'skipped', '#eceff3')
    CONTINUED = ('\u2717', 'failed, continued', '#e3dbd3')
    REJECTED = ('\u2717', 'failed, item rejected', '#f3c9bd')
    ABORTED = ('\u2717', 'failed, job aborted', '#f3c9bd')

    def __init__(self, sign: str, word: str, fill: str) -> None:
        self.sign = sign
        self.word = word
        self.fill = fill

    @property
    def needs_eyes(self) -> bool:
        """Tell whether its frame is thick: something happens here, or needs attention."""
        return self in (Mark.RUNNING, Mark.FAILED, Mark.HELD)


@dataclass(frozen=True)
class TaskMark:
    """One task now."""

    mark: Mark
    words: str = ''
    """More than its word: which attempt, which hold."""
    reason: str = ''
    """The cause of its wait or failure."""


@dataclass(frozen=True)
class SectionMark:
    """One section and its slot now."""

    slot: str = ''
    """Item that stands there; empty: nothing."""
    is_empty_position: bool = False
    is_rejected: bool = False
    is_nonconforming: bool = False
    """Of the item in the slot; both may be so."""
    works_on: str = ''
    """Item of the cycle in hand, with the job's script if that is not the one that is drawn."""
    finished: str = ''
    """Item of the cycle that it completed in this beat."""
    waiting: tuple[str, ...] = ()


@dataclass(frozen=True)
class LineState:
    """Everything that a drawing shows beside the script itself."""

    headline: str
    jobs: tuple[str, ...]
    """One line a job."""
    belt_moves: bool
    tasks: Mapping[str, TaskMark] = field(default_factory=dict)
    """By task id, the belt's move as well."""
    sections: Mapping[int, SectionMark] = field(default_factory=dict)
    flags: Mapping[str, int] = field(default_factory=dict)
    """Counts by name."""

    def task(self, name: str) -> TaskMark:
        """Return how a task stands."""
        return self.tasks.get(name, TaskMark(Mark.NEW))
