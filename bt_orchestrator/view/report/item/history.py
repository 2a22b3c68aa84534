"""The parts of the record of one item."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from bt_orchestrator.model.codec import to_plain
from bt_orchestrator.view.report.intervals import Span

RUNNING, SUCCEEDED, FAILED = 'running', 'succeeded', 'failed'
SKIPPED, MARKED_DONE, CONTINUED = 'skipped', 'marked_done', 'continued'
"""Outcomes; the last three are of a task and no attempt."""


@dataclass(frozen=True)
class Waited:
    """A stretch of time in which an attempt could not begin yet."""

    start: float
    end: float
    kind: str
    """A value of `model.wait.WaitKind`; empty: the journal does not tell."""
    words: str
    """The cause of its wait; several causes, one after the other, are several stretches."""

    @property
    def seconds(self) -> float:
        """How long."""
        return self.end - self.start


@dataclass(frozen=True)
class AtWork:
    """Another attempt that ran at the same time."""

    component: str
    name: str
    """Task constant."""
    item: str
    """Empty: it was the belt's move, or initialization."""
    section: int | None


@dataclass
class Attempt:
    """One attempt of a task, or what was decided instead of one."""

    section: int | None
    task: str
    outcome: str
    name: str = ''
    """Task constant; empty: nothing was sent."""
    component: str = ''
    round: int = 0
    """The number of the further round of its repeat, from 1; 0: the first pass, or no repeat."""
    attempt: int = 0
    started: float | None = None
    ended: float | None = None
    seconds: float | None = None
    reason: str = ''
    message: str = ''
    controller_said: str = ''
    """Text of the controller's own result."""
    last_feedback: str = ''
    """Before it failed, as one JSON object."""
    topic_says: str = ''
    """Where no result came: the end of its goal by the status topic."""
    args: Mapping[str, Any] = field(default_factory=dict)
    results: Mapping[str, Any] = field(default_factory=dict)
    waited: list[Waited] = field(default_factory=list)
    """Since what it follows had ended: the task before it, or the attempt before it."""
    beside: list[AtWork] = field(default_factory=list)
    """The other tasks that ran while it ran."""
    adopted: int = 0
    """How often a node that was started again found its goal at the controller."""
    resent: int = 0
    """How often its goal was sent again, because the server did not know it."""
    cancelled: str = ''
    """Why it was cancelled: timeout, abort_job, abort or shutdown; empty: it was not."""


@dataclass(frozen=True)
class Decision:
    """Decisions about an item, or about the whole cell while the item was there."""

    time: float
    who: str
    what: str
    reason: str
    hold: str = ''
    """The hold that was answered; empty: none."""
    role: str = ''
    known: str = ''
    """How it is known who that is (`model.by.Known`)."""
    of_cell: bool = False


@dataclass
class Held:
    """A hold about an item, or about the whole cell while the item was there."""

    id: str
    seq: int
    """Of the event that raised it."""
    time: float
    task: str
    words: str
    of_cell: bool = False
    ended: float | None = None
    """None: it is open, or the item ended first."""


@dataclass(frozen=True)
class Neighbour:
    """The content of another slot of the belt."""

    section: int
    item: str


@dataclass
class Stay:
    """The time of an item in the slot of one section."""

    section: int
    since: float
    until: float | None = None
    """When the belt began to carry it on, or it left the belt."""
    beside: tuple[Neighbour, ...] = ()
    """All other items on the belt, when the stay ended; downstream last."""


@dataclass(frozen=True)
class Restart:
    """A node took over while the item was there."""

    time: float
    silent_since: float
    """The last event of the node before."""
    words: str
    """The facts that it did not know; empty: it went on from its last event."""


@dataclass(frozen=True)
class ClockSet:
    """The clock was set while the item was there."""

    time: float
    seconds: float
    """By how much, forward; negative: back."""


@dataclass
class ItemHistory:
    """An item from its source cycle to its end."""

    item: str
    job: str
    script: str = ''
    recipe: str = ''
    """Name of the recipe that the script was generated from; empty: none, or not known."""
    recipe_version: int | None = None
    digest: str = ''
    """Of the script, which is in the journal."""
    quantity: int = 0
    """Of the order."""
    params: Mapping[str, Any] = field(default_factory=dict)
    """Of the order."""
    started: float | None = None
    ended: float | None = None
    how: str = ''
    """packed, rejected, by_hand or missing; empty while it is on the line."""
    rejected: str = ''
    """Why it was rejected; empty: it was not."""
    first_piece: str = ''
    """As a first piece: approved, refused, or waits (semantics 6.12); empty: it was none."""
    nonconforming: list[str] = field(default_factory=list)
    """Tasks that failed for it and were passed all the same, or that an operator let it pass."""
    serial: str = ''
    lots: Mapping[str, str] = field(default_factory=dict)
    tasks: list[Attempt] = field(default_factory=list)
    holds: list[Held] = field(default_factory=list)
    decisions: list[Decision] = field(default_factory=list)
    stays: list[Stay] = field(default_factory=list)
    restarts: list[Restart] = field(default_factory=list)
    clock_set: list[ClockSet] = field(default_factory=list)
    """All times are of the clock at the time when the item came, without later steps."""
    idle: list[Waited] = field(default_factory=list)
    """The cause of its wait while it had no task to wait for; known once it has ended."""

    @property
    def work(self) -> list[Span]:
        """The times in which its tasks ran."""
        return [
            Span(task.started, task.ended)
            for task in self.tasks
            if task.started is not None and task.ended is not None
        ]


def plain_item(history: ItemHistory) -> dict[str, Any]:
    """Return a record as data that JSON can carry."""
    plain: dict[str, Any] = to_plain(history, whole=True)
    if not history.clock_set:
        del plain['clock_set']
    return plain
