"""The events of tasks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

from bt_orchestrator.model.cell import OnFailure
from bt_orchestrator.model.events.base import Event, TaskKey
from bt_orchestrator.model.frozen import made_at_once, worked_out


@dataclass(frozen=True, kw_only=True)
class TaskEvent(Event):
    """Something about one task."""

    job: str | None = None
    section: int | None = None
    item: str | None = None
    task: str

    @worked_out
    def key(self) -> TaskKey:
        """The task and its item."""
        return TaskKey(self.job, self.section, self.item, self.task)


@made_at_once
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
    uptime: float | None = None
    """Seconds for which the machine had been up when it was sent, in the boot that
    `orchestrator.started` names."""
    round: int = 0
    """The number of the further round of its repeat, from 1; 0: the first pass, or no repeat."""


@dataclass(frozen=True, kw_only=True)
class TaskAdopted(TaskEvent):
    """After a restart the server has confirmed that it has the goal in flight (semantics 9.2)."""

    event: ClassVar[str] = 'task.adopted'
    attempt: int
    goal: str


@dataclass(frozen=True, kw_only=True)
class TaskResent(TaskEvent):
    """After a restart the server does not know the goal in flight, and it is sent again.

    The UUID is the same. The task is repeatable, or the goal is proven never to have arrived
    (semantics 9.2).
    """

    event: ClassVar[str] = 'task.resent'
    attempt: int
    goal: str
    server: str | None = None
    """As in `task.started`."""
    uptime: float | None = None
    """As in `task.started`."""


@dataclass(frozen=True, kw_only=True)
class TaskCancelRequested(TaskEvent):
    """The orchestrator asks the server to cancel a goal in flight."""

    event: ClassVar[str] = 'task.cancel_requested'
    goal: str
    cause: str
    """timeout, abort_job, abort or shutdown; in manual mode panel_lost or cancel_task."""


@made_at_once
@dataclass(frozen=True, kw_only=True)
class TaskSucceeded(TaskEvent):
    """The task was done (semantics 2.2)."""

    event: ClassVar[str] = 'task.succeeded'
    attempt: int
    goal: str
    results: Mapping[str, Any] = field(default_factory=dict)
    left_out: tuple[str, ...] = ()
    """Fields that were too long to record: the longest of a result of more than 4 MB."""


@dataclass(frozen=True, kw_only=True)
class TaskFailed(TaskEvent):
    """One attempt failed; what follows is decided by retries and policy (semantics 2.6, 2.7)."""

    event: ClassVar[str] = 'task.failed'
    attempt: int
    goal: str | None = None
    """None where nothing was sent (missing_result)."""
    reason: str
    message: str = ''
    results: Mapping[str, Any] = field(default_factory=dict)
    """The refused results (result_refused, duplicate_serial)."""
    left_out: tuple[str, ...] = ()
    """As in `task.succeeded`."""
    round: int = 0
    """As in `task.started`."""
    controller_said: str = ''
    """Text of the controller's own result, cut."""
    last_feedback: str = ''
    """Last feedback of the attempt, as one JSON object."""
    topic_says: str = ''
    """Where no result came: succeeded, canceled or aborted, by the action's status topic; it
    decides nothing."""
    never_begun: bool = False
    """The goal was cancelled, and no server ever had it."""


@dataclass(frozen=True, kw_only=True)
class TaskRetrying(TaskEvent):
    """Another attempt will be made, not before `not_before`."""

    event: ClassVar[str] = 'task.retrying'
    attempt: int
    """The attempt to come."""
    not_before: float
    """Seconds, on the clock of `time`."""
    uptime: float | None = None
    """As in `task.started`, when it was decided."""


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

    @property
    def nonconforming(self) -> str | None:
        """The item that is nonconforming by it (semantics 2.7); None: none is."""
        return self.item if self.policy == OnFailure.CONTINUE.value else None


@dataclass(frozen=True, kw_only=True)
class TaskMarkedDone(TaskEvent):
    """An operator answered that the task is done, overriding the controller."""

    event: ClassVar[str] = 'task.marked_done'
    results: Mapping[str, Any] = field(default_factory=dict)
    """Result fields that the operator gave, for references of later tasks."""


TASK_EVENTS = (
    TaskStarted,
    TaskAdopted,
    TaskResent,
    TaskCancelRequested,
    TaskSucceeded,
    TaskFailed,
    TaskRetrying,
    TaskSkipped,
    TaskContinued,
    TaskMarkedDone,
)
"""Events that change the phase of a task; flags have separate events."""
