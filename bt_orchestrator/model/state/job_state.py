"""Jobs, from acceptance to their end, and their items."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from bt_orchestrator.model.jobs.counting import good_of
from bt_orchestrator.model.jobs.order import Job, MadeAnew


@dataclass
class ItemState:
    """One unit on the line, from the start of its source cycle to its end."""

    id: str
    job: str
    number: int
    section: int = 0
    """Section of its slot; 0: none (not placed yet, or gone)."""
    present: bool = True
    """False: an empty position (semantics 3.2)."""
    rejected: bool = False
    gone: bool = False
    """It left the belt; kept only while a cycle still works on its data."""
    open_cycles: int = 0
    nonconforming: list[str] = field(default_factory=list)
    """Ids of the tasks that failed and were continued, or that an operator let it pass without
    the verdict (semantics 2.7, 2.8)."""
    results: dict[str, Mapping[str, Any]] = field(default_factory=dict)
    """Result fields by task id (semantics 6.3)."""
    serial: str = ''
    """Its serial; empty: not known (semantics 6.8)."""
    lots: Mapping[str, str] = field(default_factory=dict)
    """The lots that go into it, by name; empty before it is placed (semantics 6.9)."""
    counted: int = 0
    """Its number among the items that are counted with it (semantics 7.7); 0: it is not counted,
    or is counted as a reject already."""


@dataclass
class Progress:
    """Counts of one job (semantics 6.2)."""

    started: int = 0
    """Source cycles begun."""
    placed: int = 0
    processed: int = 0
    """Good items that have passed every section before the sink."""
    packed: int = 0
    rejected: int = 0
    """Rejected items that have left the line."""
    nonconforming: int = 0
    """Of the packed ones, those that were as they left."""
    missing: int = 0
    removed: int = 0
    """Of the missing, those that were placed and taken out by hand."""

    @property
    def good(self) -> int:
        """Packed, and conforming as they left."""
        return good_of(self.packed, self.nonconforming)

    @property
    def by_hand(self) -> int:
        """The name of `removed` outside of the state."""
        return self.removed


@dataclass
class JobState:
    """A job from acceptance to its end."""

    job: Job
    digest: str
    recipe: str = ''
    """The source of its generated script; of equal scripts the state keeps one."""
    recipe_version: int | None = None
    rest_of: str = ''
    """The job whose items it makes that this had not begun (semantics 7.6); empty: none."""
    anew: MadeAnew | None = None
    """Why its script was generated again, if it was (semantics 7.5)."""
    queued_at: float = 0.0
    started_at: float | None = None
    ended_at: float | None = None
    held: bool = False
    """It may not start, and later jobs pass it; never set once it has started."""
    awaits_start: bool = False
    """The same until the start of its order (semantics 6.7)."""
    awaits_release: bool = False
    """The same until its script is released (semantics 6.10)."""
    unavailable: tuple[str, ...] = ()
    """Components out of service that it needs; the same until they are in service (semantics 7.5).
    Empty once it has started."""
    ranked: bool = False
    """Its place in the queue follows from its priority and start; False: it was given."""
    paused: bool = False
    """It begins no more items until it is resumed."""
    wants_piece: bool = False
    """The next item that it begins is its first piece (semantics 6.12)."""
    piece: str = ''
    """The first piece whose approval it waits for; empty: it waits for none."""
    piece_left: str = ''
    """How that has left the line: packed, rejected, by_hand or missing; empty: it has not."""
    approved: str = ''
    """The first piece that was approved; empty: none was."""
    stopping: bool = False
    """It begins no more items, and ends when those on the line have left it."""
    aborting: bool = False
    end_reason: str = ''
    """Why it was stopped or aborted."""
    progress: Progress = field(default_factory=Progress)
    items: dict[str, ItemState] = field(default_factory=dict)
    """Items that are on the line or in a cycle, oldest first."""

    @property
    def started(self) -> bool:
        """Tell whether it has left the queue."""
        return self.started_at is not None

    @property
    def may_start(self) -> bool:
        """Tell whether it starts when its turn comes."""
        return not (
            self.held
            or self.awaits_start
            or self.awaits_release
            or self.unavailable
            or self.ending
        )

    @property
    def unreleased(self) -> str:
        """The digest of its script, if it waits for the release of it; else empty."""
        return self.digest if self.awaits_release else ''

    @property
    def cycles_left(self) -> int:
        """Count the source cycles that have not begun."""
        if self.aborting or self.stopping:
            return 0
        return self.job.quantity - self.progress.started

    @property
    def ending(self) -> str:
        """Say how it ends before its time, from when that was asked: aborting, stopping."""
        return 'aborting' if self.aborting else 'stopping' if self.stopping else ''

    @property
    def exit_status(self) -> str:
        """How it ends: completed, stopped, or aborted."""
        if self.aborting:
            return 'aborted'
        return 'completed' if self.progress.started == self.job.quantity else 'stopped'
