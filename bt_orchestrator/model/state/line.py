"""The position of the belt, the state of the components, and the tasks of items."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

from bt_orchestrator.model.frozen import made_at_once
from bt_orchestrator.model.goal import Reason
from bt_orchestrator.model.script import Task
from bt_orchestrator.model.uptime import Uptime


class Phase(Enum):
    """The phase of a task. A task without a state is new."""

    RUNNING = 'running'
    """An attempt is in flight."""
    FAILED = 'failed'
    """The attempt failed and nothing is decided yet."""
    RETRYING = 'retrying'
    """Another attempt was decided; it may start when `not_before` has passed."""
    HELD = 'held'
    """An operator must answer."""
    DONE = 'done'
    """Succeeded, skipped or continued: the cycle has passed it."""


class End(Enum):
    """How a passed task ended; a status shows these words."""

    DONE = 'done'
    MARKED_DONE = 'marked_done'
    """An operator said so."""
    SKIPPED = 'skipped'
    CONTINUED = 'continued'
    """It failed, and the item is nonconforming."""
    REJECTED = 'rejected'
    """It failed, and the item is rejected."""
    ABORTED = 'aborted'
    """It failed, and the job is aborted."""

    @property
    def is_failure(self) -> bool:
        """Tell whether its last attempt failed."""
        return self in (End.CONTINUED, End.REJECTED, End.ABORTED)


@made_at_once
@dataclass(frozen=True)
class TaskState:
    """Progress of one task of one item."""

    phase: Phase
    attempt: int = 0
    goal: str | None = None
    started: float = 0.0
    """Seconds, when the last attempt began."""
    args: Mapping[str, Any] = field(default_factory=dict)
    sent: float = 0.0
    """Seconds, when the goal was sent last; later than `started` if it was sent again."""
    server: str | None = None
    """Instance of the server that it was sent to then; None: not known."""
    sent_up: Uptime | None = None
    """`sent` as uptime, which is never set."""
    sent_seq: int = 0
    """The event that let it be sent last; 0: from a state older than this field."""
    cancel_cause: str | None = None
    """Why the orchestrator itself cancelled the goal in flight, if it did."""
    cancelled_at: float = 0.0
    copied: bool = False
    """It was in flight in the restored copy: missing events of it prove nothing."""
    reason: Reason | None = None
    """Why the last attempt failed."""
    message: str = ''
    """Message of the failure, or why it was skipped."""
    refused: Mapping[str, Any] = field(default_factory=dict)
    """Results of the last attempt, if they were refused (semantics 2.8, 6.8)."""
    controller_said: str = ''
    """As in `task.failed`, of the last attempt; the next three too."""
    last_feedback: str = ''
    topic_says: str = ''
    never_begun: bool = False
    end: End | None = None
    """How it ended, in phase DONE; None: from a journal older than this field."""
    not_before: float = 0.0
    delay_s: float = 0.0
    """Delay of the retry, as decided."""
    delayed_up: Uptime | None = None
    """Time of that decision as uptime, which is never set."""
    hold: str | None = None


@dataclass(frozen=True)
class ManualRun:
    """A goal of manual mode, from when it was asked for (semantics 7.11)."""

    component: str
    name: str
    """Task constant."""
    who: str
    known: str
    """How it is known who that is."""
    reason: str
    asked: float
    args: Mapping[str, Any] = field(default_factory=dict)
    hold: str = ''
    """The hold that keeps the component; empty: none does."""
    ended: float | None = None
    """When its goal ended, or was given up; None: it has not."""
    results: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class PassedTask:
    """A task that the cell has passed, and how it ended."""

    id: str
    end: End
    """done, marked_done or skipped; after a failure continued, rejected or aborted."""
    reason: str = ''
    """Why it was skipped, or failed."""


def same_task(task: Task) -> str:
    """Return a key of a task's action and constant, without its arguments (semantics 5.1)."""
    return f'{task.action} {task.name}'


def same_args(args: Mapping[str, Any]) -> str:
    """Return a key of arguments; equal ones have equal keys."""
    return repr(sorted(args.items()))


@made_at_once
@dataclass(frozen=True)
class Cycle:
    """A section's pass through its list for one item."""

    job: str
    item: str
    beat: int
    """The beat its turn belongs to (semantics 3.7)."""
    rounds: Mapping[str, int] = field(default_factory=dict)
    """Further rounds begun, by the name of the repeat (semantics 3.9)."""
    round_causes: Mapping[str, str] = field(default_factory=dict)
    """Why the last of these rounds began, by the name of the repeat."""


@dataclass(frozen=True)
class Finished:
    """The outcome of a completed cycle."""

    job: str
    item: str
    beat: int
    """The beat of the cycle."""
    passed: tuple[PassedTask, ...] = ()
    failed: tuple[str, ...] = ()
    """Ids of tasks that failed and were passed all the same."""


@dataclass
class SectionState:
    """One section: its cycle in hand and its turn."""

    number: int
    cycle: Cycle | None = None
    turn_beat: int = 0
    """The last beat in which it completed a turn."""
    slot: str | None = None
    """Item, or empty position, that stands here."""
    finished: Finished | None = None
    """The last cycle that it completed, until the belt has moved after it."""


@dataclass
class FlagState:
    """The counter of a lateral dependency (semantics 4.1)."""

    count: int
    capacity: int


@dataclass(frozen=True)
class Reject:
    """A rejected item among those that are counted with it (semantics 7.7)."""

    number: int
    """Its place in the order in which they were begun, from 1."""
    item: str
    facts: Mapping[str, str]
    """How it was rejected: what several of them may have in common."""


@dataclass
class RejectCount:
    """The items of a script with a limit, or of all scripts without one (semantics 7.7)."""

    begun: int = 0
    rejects: list[Reject] = field(default_factory=list)
    """Those that may still be part of a run, in the order in which they were rejected."""
    hold: str | None = None
    """The hold that they have raised, until it is released."""


@dataclass(frozen=True)
class Reading:
    """Last value of a component's state topic; not ready before the first one."""

    ready: bool
    value: Any = None


@dataclass(frozen=True)
class KnownSetup:
    """The present value of a setup (semantics 5.3)."""

    value: str
    server: str | None = None
    """Instance of the server that made it; None: not known."""
    is_told: bool = False
    """The state topic of the component has told it."""


@dataclass(frozen=True)
class OutOfService:
    """A component that an operator took out of service (semantics 7.5)."""

    reason: str
    """The person who did it, and the reason."""
    since: float
