"""What happened: the only way in which the state of the cell changes.

Journal, trace, ROS topic and exports carry the same records (formats: events). Where a place in
the line matters an event names job, section, item and task; fields that do not apply are None and
absent from the record.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar, NamedTuple

from bt_orchestrator.model.script import INDEX, Script


class TaskKey(NamedTuple):
    """Which task of which item; unique among the tasks that can exist at one time."""

    job: str | None
    """None for the belt's own move."""
    section: int | None
    """None for initialization and for the belt's own move."""
    item: str | None
    task: str

    def __str__(self) -> str:
        if self.job is None:
            return self.task
        return f'{self.task} of {self.item or self.job}'


INDEX_KEY = TaskKey(None, None, None, INDEX)
"""The belt's own move (formats: events)."""


@dataclass(frozen=True, kw_only=True)
class Event:
    """Base of all events. `seq` and `time` are stamped when the event is recorded."""

    event: ClassVar[str]
    """Name in the record, for instance task.started."""

    seq: int = 0
    time: float = 0.0
    """Seconds since the epoch in a real run, from 0 in a virtual one."""


# --- jobs -----------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class ScriptLoaded(Event):
    """A script is known from here on; jobs name it by its digest, whatever becomes of the file."""

    event: ClassVar[str] = 'script.loaded'
    script: str
    digest: str
    definition: Script


@dataclass(frozen=True, kw_only=True)
class JobQueued(Event):
    """A work order was accepted."""

    event: ClassVar[str] = 'job.queued'
    job: str
    script: str
    digest: str
    quantity: int
    params: Mapping[str, Any] = field(default_factory=dict)
    position: int | None = None
    """Place in the queue, from 1; None: the end."""
    held: bool = False
    """It may not start before it is released."""


@dataclass(frozen=True, kw_only=True)
class JobMoved(Event):
    """A queued job has another place in the queue."""

    event: ClassVar[str] = 'job.moved'
    job: str
    position: int
    """Place in the queue, from 1; jobs that have started are not in it."""


@dataclass(frozen=True, kw_only=True)
class JobUpdated(Event):
    """A queued job was changed; the fields say all of what it is now."""

    event: ClassVar[str] = 'job.updated'
    job: str
    script: str
    digest: str
    quantity: int
    params: Mapping[str, Any] = field(default_factory=dict)


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
    """Nothing of the job is on the line any more; it did its cycles, or it was stopped."""

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


@dataclass(frozen=True, kw_only=True)
class JobResumed(Event):
    """The job begins items again."""

    event: ClassVar[str] = 'job.resumed'
    job: str


@dataclass(frozen=True, kw_only=True)
class JobStopping(Event):
    """The job begins no more items, and ends when those on the line have left it."""

    event: ClassVar[str] = 'job.stopping'
    job: str
    reason: str


@dataclass(frozen=True, kw_only=True)
class JobAborting(Event):
    """The job will end early: no new source cycle, its items are rejected and drain."""

    event: ClassVar[str] = 'job.aborting'
    job: str
    reason: str


@dataclass(frozen=True, kw_only=True)
class JobAborted(Event):
    """Nothing of an aborting job is on the line any more."""

    event: ClassVar[str] = 'job.aborted'
    job: str
    exit_status: str = ''
    """aborted; None in old journals."""
    reason: str = ''
    counts: Mapping[str, int] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class JobCleared(Event):
    """An ended job is not listed any more."""

    event: ClassVar[str] = 'job.cleared'
    job: str


# --- the queue ------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class QueueStopRequested(Event):
    """The line is to run empty; then the cell stops."""

    event: ClassVar[str] = 'queue.stop_requested'
    after: str
    """item: no item is begun any more; job: no job."""


@dataclass(frozen=True, kw_only=True)
class QueueStopCancelled(Event):
    """The line is not to run empty any more."""

    event: ClassVar[str] = 'queue.stop_cancelled'


@dataclass(frozen=True, kw_only=True)
class QueueStopReached(Event):
    """The line is empty, as was asked for; the cell stops."""

    event: ClassVar[str] = 'queue.stop_reached'
    after: str
    """item or job, as it was asked for."""


# --- tasks ----------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class TaskEvent(Event):
    """Something about one task."""

    job: str | None = None
    section: int | None = None
    item: str | None = None
    task: str

    @property
    def key(self) -> TaskKey:
        """Which task of which item."""
        return TaskKey(self.job, self.section, self.item, self.task)


@dataclass(frozen=True, kw_only=True)
class TaskStarted(TaskEvent):
    """An attempt begins: its goal is sent once this event is durable (semantics 9.1)."""

    event: ClassVar[str] = 'task.started'
    name: str
    """Task constant."""
    action: str
    component: str
    attempt: int
    goal: str
    args: Mapping[str, Any] = field(default_factory=dict)
    server: str | None = None
    """Instance of the action server when it was sent, as its status publisher's id tells."""


@dataclass(frozen=True, kw_only=True)
class TaskAdopted(TaskEvent):
    """After a restart the goal in flight is asked for by its UUID (semantics 9.2)."""

    event: ClassVar[str] = 'task.adopted'
    attempt: int
    goal: str


@dataclass(frozen=True, kw_only=True)
class TaskResent(TaskEvent):
    """The server does not know an adopted goal, and it is sent again, with the same UUID.

    The task is repeatable, or the goal is proven never to have arrived (semantics 9.2).
    """

    event: ClassVar[str] = 'task.resent'
    attempt: int
    goal: str
    server: str | None = None
    """As in `task.started`."""


@dataclass(frozen=True, kw_only=True)
class TaskCancelRequested(TaskEvent):
    """The orchestrator asks the server to cancel a goal in flight."""

    event: ClassVar[str] = 'task.cancel_requested'
    goal: str
    cause: str
    """timeout, abort_job, abort or shutdown."""


@dataclass(frozen=True, kw_only=True)
class TaskSucceeded(TaskEvent):
    """The task was done (semantics 2.2)."""

    event: ClassVar[str] = 'task.succeeded'
    attempt: int
    goal: str
    results: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class TaskFailed(TaskEvent):
    """One attempt failed; what follows is decided by retries and policy (semantics 2.6, 2.7)."""

    event: ClassVar[str] = 'task.failed'
    attempt: int
    goal: str | None = None
    """None where nothing was sent (missing_result)."""
    reason: str
    message: str = ''


@dataclass(frozen=True, kw_only=True)
class TaskRetrying(TaskEvent):
    """Another attempt will be made, not before `not_before`."""

    event: ClassVar[str] = 'task.retrying'
    attempt: int
    """The attempt to come."""
    not_before: float
    """Seconds, on the clock of `time`."""


@dataclass(frozen=True, kw_only=True)
class TaskSkipped(TaskEvent):
    """The task was not needed; its flag operations are done (semantics 4.2)."""

    event: ClassVar[str] = 'task.skipped'
    reason: str


@dataclass(frozen=True, kw_only=True)
class TaskContinued(TaskEvent):
    """The task failed for good and the cycle goes on without it."""

    event: ClassVar[str] = 'task.continued'
    policy: str
    """continue, reject or abort_job."""


@dataclass(frozen=True, kw_only=True)
class TaskMarkedDone(TaskEvent):
    """An operator answered that the task is done, whatever the controller said."""

    event: ClassVar[str] = 'task.marked_done'


# --- cycles, flags, the belt ----------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class CycleEvent(Event):
    """Something about one pass of a section through its list."""

    job: str
    section: int
    item: str


@dataclass(frozen=True, kw_only=True)
class CycleStarted(CycleEvent):
    """A section begins its list for an item; at the source the item exists from here on."""

    event: ClassVar[str] = 'cycle.started'
    beat: int
    """The beat this cycle's turn belongs to; the one to come for a cycle begun ahead."""


@dataclass(frozen=True, kw_only=True)
class TurnCompleted(CycleEvent):
    """The section releases the conveyor (semantics 3.4, 3.8)."""

    event: ClassVar[str] = 'turn.completed'


@dataclass(frozen=True, kw_only=True)
class CycleCompleted(CycleEvent):
    """All steps of the list have ended."""

    event: ClassVar[str] = 'cycle.completed'


@dataclass(frozen=True, kw_only=True)
class FlagEvent(TaskEvent):
    """A lateral dependency's counter changed, by the task named."""

    flag: str
    count: int
    """After the change."""


@dataclass(frozen=True, kw_only=True)
class FlagRaised(FlagEvent):
    """The upstream task executed: one more."""

    event: ClassVar[str] = 'flag.raised'


@dataclass(frozen=True, kw_only=True)
class FlagLowered(FlagEvent):
    """The downstream task executed: one less."""

    event: ClassVar[str] = 'flag.lowered'


@dataclass(frozen=True, kw_only=True)
class BeatStarted(Event):
    """A beat begins without a move, the belt being empty (semantics 3.5)."""

    event: ClassVar[str] = 'beat.started'
    beat: int


@dataclass(frozen=True, kw_only=True)
class BeltIndexStarted(Event):
    """The belt leaves its rest; it stays so until `belt.indexed`, retries and holds included."""

    event: ClassVar[str] = 'belt.index_started'
    beat: int
    """The beat that ends."""


@dataclass(frozen=True, kw_only=True)
class BeltIndexed(Event):
    """The belt is at rest one position further; every item has moved."""

    event: ClassVar[str] = 'belt.indexed'
    beat: int
    """The beat that begins."""


# --- items ----------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class ItemEvent(Event):
    """Something about one item."""

    job: str
    item: str


@dataclass(frozen=True, kw_only=True)
class ItemPlaced(ItemEvent):
    """The item stands in the slot of the source section."""

    event: ClassVar[str] = 'item.placed'
    section: int


@dataclass(frozen=True, kw_only=True)
class ItemMissing(ItemEvent):
    """The item was never placed: an empty position stands in its slot (semantics 3.2)."""

    event: ClassVar[str] = 'item.missing'
    section: int


@dataclass(frozen=True, kw_only=True)
class ItemMoved(ItemEvent):
    """The item, or empty position, moved into the slot of a section."""

    event: ClassVar[str] = 'item.moved'
    section: int
    """The section it moved into."""


@dataclass(frozen=True, kw_only=True)
class ItemRejected(ItemEvent):
    """The item is bad; remaining tasks skip it, except those for rejected items."""

    event: ClassVar[str] = 'item.rejected'
    reason: str


@dataclass(frozen=True, kw_only=True)
class ItemRemoved(ItemEvent):
    """The item left the belt; by hand or before the sink, it leaves an empty position."""

    event: ClassVar[str] = 'item.removed'
    section: int | None = None
    how: str
    """packed, rejected or by_hand."""


@dataclass(frozen=True, kw_only=True)
class PositionEnded(ItemEvent):
    """An empty position ended at the sink (semantics 3.2)."""

    event: ClassVar[str] = 'position.ended'
    section: int


# --- components, holds, the cell ------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class ComponentStateChanged(Event):
    """A state topic says something new (semantics 2.5)."""

    event: ClassVar[str] = 'component.state_changed'
    component: str
    ready: bool
    value: Any = None
    """None: nothing is published any more."""


@dataclass(frozen=True, kw_only=True)
class HoldRaised(Event):
    """Something waits for an operator (semantics 7.1)."""

    event: ClassVar[str] = 'hold.raised'
    hold: str
    job: str | None = None
    section: int | None = None
    item: str | None = None
    task: str | None = None
    reason: str
    message: str = ''
    answers: tuple[str, ...] = ()
    owner: str = ''
    """Who paused the cell; empty: it is nobody's, anyone may end it."""


@dataclass(frozen=True, kw_only=True)
class HoldReleased(Event):
    """The hold is over."""

    event: ClassVar[str] = 'hold.released'
    hold: str


@dataclass(frozen=True, kw_only=True)
class OperatorDecided(Event):
    """An operator answered or commanded something."""

    event: ClassVar[str] = 'operator.decided'
    answer: str
    who: str
    reason: str
    origin: str = ''
    """Where the command came from, for instance the program and the computer."""
    hold: str | None = None
    job: str | None = None
    item: str | None = None


@dataclass(frozen=True, kw_only=True)
class OperatorRefused(Event):
    """A command to the cell was refused; nothing was changed."""

    event: ClassVar[str] = 'operator.refused'
    command: str
    who: str
    reason: str
    origin: str = ''
    """Where the command came from."""
    message: str
    """Why it was refused."""


@dataclass(frozen=True, kw_only=True)
class OrchestratorStarted(Event):
    """An orchestrator took the cell over, with whatever the journal says of it."""

    event: ClassVar[str] = 'orchestrator.started'
    cell: str
    digest: str
    """Of the cell's definition."""


@dataclass(frozen=True, kw_only=True)
class OrchestratorStopping(Event):
    """The node ends: goals are cancelled, and nothing starts before another one takes over."""

    event: ClassVar[str] = 'orchestrator.stopping'


@dataclass(frozen=True, kw_only=True)
class StopReasonChanged(Event):
    """Why the line stands still has changed; PackML and ISA-95 states follow from it (7.2)."""

    event: ClassVar[str] = 'cell.stop_reason_changed'
    stop_reason: str
    """operator, own_fault, starved, blocked or emergency; empty: it does not stand still."""
    reason: str = ''


@dataclass(frozen=True, kw_only=True)
class CellStateChanged(Event):
    """The cell entered another PackML state (semantics 7.2)."""

    event: ClassVar[str] = 'cell.state_changed'
    state: str
    previous: str
    cause: str = ''
    """PackML command, given or due by itself, or done: what the state was there for is done."""
    reason: str = ''
