"""Events of scripts, jobs and the queue."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

from bt_orchestrator.model.events.base import Event
from bt_orchestrator.model.jobs.order import MadeAnew, RecipeChoice
from bt_orchestrator.model.script import Script


@dataclass(frozen=True, kw_only=True)
class ScriptLoaded(Event):
    """A script was loaded; jobs refer to it by its digest, independent of the file."""

    event: ClassVar[str] = 'script.loaded'
    script: str
    digest: str
    definition: Script


@dataclass(frozen=True, kw_only=True)
class ScriptReleased(Event):
    """A generated script may be used on this cell; jobs that waited for that may start."""

    event: ClassVar[str] = 'script.released'
    digest: str
    cell_digest: str
    """Of the cell that it is released for; it does not count for another one."""
    reason: str = ''
    """The person who did it, and the reason; empty: a virtual run."""


@dataclass(frozen=True, kw_only=True)
class OrderEvent(Event):
    """The complete work order of a job in the queue, from now on."""

    job: str
    script: str
    digest: str
    quantity: int
    params: Mapping[str, Any] = field(default_factory=dict)
    priority: int = 0
    """The higher the more urgent."""
    start: float | None = None
    """When it should begin, seconds since the epoch; None: not said."""
    due: float | None = None
    """When it should have ended, seconds since the epoch; None: not said."""
    details: Mapping[str, object] = field(default_factory=dict)
    """The customer's JSON, as given."""
    first_piece: bool = False
    """The order asks for an approval of its first item (semantics 6.12)."""
    awaits_start: bool = False
    """It may not start before `start`."""
    awaits_release: bool = False
    """Its script was generated, and is not released for this cell (semantics 6.10)."""
    recipe: str = ''
    """Name of the recipe that the script was generated from; empty: it was written by hand, or the
    record is of an older program."""
    recipe_version: int | None = None
    """Version of the recipe; absent: it has none, or is not known."""
    recipe_digest: str = ''
    """Name of the recipe by what it says; empty: as `recipe`, or the script does not tell it."""
    choice: RecipeChoice | None = None
    """The recipe that the order named in place of a script; absent: it named a script."""
    unavailable: tuple[str, ...] = ()
    """Components out of service that it needs: it is passed (semantics 7.5)."""


@dataclass(frozen=True, kw_only=True)
class JobQueued(OrderEvent):
    """A work order was accepted."""

    event: ClassVar[str] = 'job.queued'
    position: int | None = None
    """Place in the queue, from 1; None: the end."""
    held: bool = False
    """It may not start before it is released."""
    ranked: bool = False
    """Its place follows from its priority and start (6.7); false: it was given, or is of an older
    program."""
    rest_of: str = ''
    """The job whose items it makes that this had not begun (semantics 7.6); empty: none."""
    anew: MadeAnew | None = None
    """How its script differs from that of the job, as in `job.updated`; absent: it does not."""


@dataclass(frozen=True, kw_only=True)
class JobMoved(Event):
    """A queued job was put at another place in the queue, where it stays."""

    event: ClassVar[str] = 'job.moved'
    job: str
    position: int
    """Place in the queue, from 1; jobs that have started are not in it."""


@dataclass(frozen=True, kw_only=True)
class QueueArranged(Event):
    """The queue was put into an order that was proposed; no place in it was chosen by a person."""

    event: ClassVar[str] = 'queue.arranged'
    jobs: tuple[str, ...]
    """Its first jobs in their new order; all others keep their places."""


@dataclass(frozen=True, kw_only=True)
class JobUpdated(OrderEvent):
    """A queued job was changed; the fields are its complete new values."""

    event: ClassVar[str] = 'job.updated'
    position: int | None = None
    """New place in the queue, from 1, by its new priority or start (6.7); None: as before."""
    anew: MadeAnew | None = None
    """Why its script was generated again: `without` components out of service, or because some are
    `back`; the pace in `per_item_s`, and in `before_s` that of before. Absent: it was not, or the
    record is of an older program."""


@dataclass(frozen=True, kw_only=True)
class JobHeld(Event):
    """A queued job may not start; it keeps its place and later jobs pass it."""

    event: ClassVar[str] = 'job.held'
    job: str


@dataclass(frozen=True, kw_only=True)
class JobReleased(Event):
    """A queued job may start when its turn comes."""

    event: ClassVar[str] = 'job.released'
    job: str


@dataclass(frozen=True, kw_only=True)
class JobMayStart(Event):
    """A queued job no longer waits for its start: the time has come, or a request released it."""

    event: ClassVar[str] = 'job.may_start'
    job: str


@dataclass(frozen=True, kw_only=True)
class JobRemoved(Event):
    """A job left the queue without having started."""

    event: ClassVar[str] = 'job.removed'
    job: str


@dataclass(frozen=True, kw_only=True)
class JobStarted(Event):
    """The job left the queue: its first initialization task or cycle begins."""

    event: ClassVar[str] = 'job.started'
    job: str


@dataclass(frozen=True, kw_only=True)
class JobCompleted(Event):
    """The job has left the line; it did its cycles, or it was stopped."""

    event: ClassVar[str] = 'job.completed'
    job: str
    exit_status: str = ''
    """completed, or stopped: it began fewer items than were ordered; None in old journals."""
    reason: str = ''
    counts: Mapping[str, int] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class JobPaused(Event):
    """The job begins no more items; those on the line go on."""

    event: ClassVar[str] = 'job.paused'
    job: str
    item: str | None = None
    """Its first piece, whose approval it waits for (semantics 6.12); None: a person paused it."""


@dataclass(frozen=True, kw_only=True)
class JobResumed(Event):
    """The job begins items again."""

    event: ClassVar[str] = 'job.resumed'
    job: str
    item: str | None = None
    """Its first piece, which was approved, or was refused where another is wanted; None: none."""
    another: bool = False
    """The next item is its first piece: it waits for the approval of that."""


@dataclass(frozen=True, kw_only=True)
class JobStopping(Event):
    """The job begins no more items, and ends when those on the line have left it."""

    event: ClassVar[str] = 'job.stopping'
    job: str
    reason: str
    item: str | None = None
    """Its first piece, which was refused by that; None: it waited for no approval."""


@dataclass(frozen=True, kw_only=True)
class JobAborting(Event):
    """The job will end early: no new source cycle, its items are rejected and drain."""

    event: ClassVar[str] = 'job.aborting'
    job: str
    reason: str


@dataclass(frozen=True, kw_only=True)
class JobAborted(Event):
    """An aborting job has left the line."""

    event: ClassVar[str] = 'job.aborted'
    job: str
    exit_status: str = ''
    """aborted; None in old journals."""
    reason: str = ''
    counts: Mapping[str, int] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class JobCleared(Event):
    """An ended job is no longer listed."""

    event: ClassVar[str] = 'job.cleared'
    job: str
    reason: str = ''


@dataclass(frozen=True, kw_only=True)
class QueueStopRequested(Event):
    """A request to run the line empty; then the cell stops."""

    event: ClassVar[str] = 'queue.stop_requested'
    after: str
    """item: no new item is begun; job: no new job."""


@dataclass(frozen=True, kw_only=True)
class QueueStopCancelled(Event):
    """The request to run the line empty was withdrawn."""

    event: ClassVar[str] = 'queue.stop_cancelled'


@dataclass(frozen=True, kw_only=True)
class QueueStopReached(Event):
    """The line is empty as requested; the cell stops."""

    event: ClassVar[str] = 'queue.stop_reached'
    after: str
    """item or job, as requested."""
