"""The state of the cell: plain data, changed by `model.fold` alone and read by everyone."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.contest import Contest
from bt_orchestrator.model.events import INDEX_KEY, TaskKey
from bt_orchestrator.model.goal import Reason
from bt_orchestrator.model.initialization import Preparation
from bt_orchestrator.model.jobs.live_jobs import LiveJobs
from bt_orchestrator.model.jobs.made_anew import MadeAnew
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.judging.used_ids import UsedIds
from bt_orchestrator.model.packml import PackmlState
from bt_orchestrator.model.pauses import NAMED
from bt_orchestrator.model.reference import Scope
from bt_orchestrator.model.script import Script, Task
from bt_orchestrator.model.stop_reason import StopReason
from bt_orchestrator.model.uptime import Uptime
from bt_orchestrator.model.wish import Wish

DERIVED: Mapping[str, bool] = {'derived': True}
"""Marks a field of the state that follows from the others, or from the cell file."""


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
    end: End | None = None
    """How it ended, in phase DONE; None: from a journal older than this field."""
    not_before: float = 0.0
    delay_s: float = 0.0
    """Delay of the retry, as decided."""
    delayed_up: Uptime | None = None
    """Time of that decision as uptime, which is never set."""
    hold: str | None = None


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
    """What identifies it; empty: not known (semantics 6.8)."""
    lots: Mapping[str, str] = field(default_factory=dict)
    """What goes into it, by name; none before it is placed (semantics 6.9)."""


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
    missing: int = 0
    removed: int = 0
    """Of the missing, those that were placed and taken out by hand."""


@dataclass
class JobState:
    """A job from acceptance to its end."""

    job: Job
    digest: str
    recipe: str = ''
    """What its script was generated from; of equal scripts the state keeps one."""
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


@dataclass(frozen=True)
class Cycle:
    """A section's pass through its list for one item."""

    job: str
    item: str
    beat: int
    """The beat its turn belongs to (semantics 3.7)."""
    rounds: Mapping[str, int] = field(default_factory=dict)
    """Further rounds begun, by the name of the repeat (semantics 3.9)."""


@dataclass
class SectionState:
    """One section: its cycle in hand and its turn."""

    number: int
    cycle: Cycle | None = None
    turn_beat: int = 0
    """The last beat in which it completed a turn."""
    slot: str | None = None
    """Item, or empty position, that stands here."""


@dataclass
class FlagState:
    """The counter of a lateral dependency (semantics 4.1)."""

    count: int
    capacity: int


@dataclass(frozen=True)
class Hold:
    """Something that waits for an operator (semantics 7.1)."""

    id: str
    job: str | None
    section: int | None
    item: str | None
    task: str | None
    reason: str
    message: str
    answers: tuple[str, ...]
    """The possible answers now; they change with the item and its job."""
    since: float
    owner: str = ''
    """Who paused the cell; empty: not one person."""
    name: str = ''
    """Task constant; this and the following are empty, or 0, where no task is held."""
    component: str = ''
    action: str = ''
    attempt: int = 0
    """Number of the attempt that failed, from 1; 0: none was made."""
    attempts: int = 0
    """Attempts that the script allows."""

    @property
    def is_pause(self) -> bool:
        """Tell whether it is about no task and no item, but about the whole cell."""
        return self.task is None and self.item is None

    @property
    def must_be_named(self) -> bool:
        """Tell whether only naming it releases it (semantics 7.3)."""
        return self.is_pause and self.reason in NAMED

    @property
    def key(self) -> TaskKey | None:
        """The task that is held, if it is a task."""
        if self.task is None:
            return None
        return TaskKey(self.job, self.section, self.item, self.task)


@dataclass(frozen=True)
class Reading:
    """Last value of a component's state topic; not ready before the first one."""

    ready: bool
    value: Any = None


@dataclass(frozen=True)
class OutOfService:
    """A component that an operator took out of service (semantics 7.5)."""

    reason: str
    """Who did it, and why."""
    since: float


@dataclass(eq=False)
class CellState:
    """The present state of the cell, derived only from events.

    Every field but the derived ones is kept by its annotation (`model.keeping.snapshot`).
    """

    cell: Cell = field(metadata=DERIVED)
    cell_digest: str = ''
    """Digest of the cell of the last orchestrator; empty: there was none."""
    history: str = ''
    """Name of the journal, as the last orchestrator found it."""
    boot: str = ''
    """Boot id of its machine; empty: not known."""
    seq: int = 0
    """Last event applied."""
    packml: PackmlState = PackmlState.STOPPED
    stopped_by: Wish | None = None
    """An operator stopped, aborted or cleared the cell, and none has started it since."""
    had_work: bool = False
    """There was a startable job since the cell was started; until then the cell waits for one."""
    packml_since: float = 0.0
    """When that state was entered, or the orchestrator started in it; seconds."""
    packml_times: dict[PackmlState, float] = field(default_factory=dict)
    """Seconds spent in each state before the present stay."""
    time: float = 0.0
    """Of the last event, seconds."""
    stop_reason: StopReason | None = None
    stop_message: str = ''
    """The stop reason in words."""
    shutting_down: bool = False
    """The orchestrator is shutting down; the next one continues."""
    belt_seq: int = 0
    """Last event that changed the content of the belt."""
    beat: int = 1
    indexing: bool = False
    """True from `belt.index_started` to `belt.indexed`."""
    sections: dict[int, SectionState] = field(default_factory=dict)
    scripts: dict[str, Script] = field(default_factory=dict)
    """By digest; those that a live job uses."""
    preparations: dict[str, Preparation] = field(default_factory=dict, metadata=DERIVED)
    """What initialization means in this cell, by digest."""
    jobs: LiveJobs = field(default_factory=LiveJobs)
    """Live jobs: those that have started, in the order they did, then the queue."""
    ended: dict[str, JobState] = field(default_factory=dict)
    """The last jobs that ended, oldest first."""
    order_ids: UsedIds = field(default_factory=UsedIds)
    """Ids of all jobs ever queued: an id is used once."""
    recipe_digests: dict[str, str] = field(default_factory=dict)
    """Of each version of a recipe that a job was ever made from, what it said (semantics 8.6)."""
    serials: UsedIds = field(default_factory=UsedIds)
    """Serials of all items that ever had one (semantics 6.8)."""
    stop_after: str | None = None
    """`item` or `job`: the line runs empty, and the cell stops (semantics 6.6)."""
    stop_after_by: Wish | None = None
    """Who requested that; None: not requested."""
    items: dict[str, ItemState] = field(default_factory=dict)
    tasks: dict[TaskKey, TaskState] = field(default_factory=dict)
    running: dict[TaskKey, TaskState] = field(default_factory=dict)
    """The tasks in phase RUNNING."""
    reserved: dict[str, TaskKey] = field(default_factory=dict)
    """Components that a task has, by name."""
    zones: dict[str, TaskKey] = field(default_factory=dict)
    """Zones that a task is in, by name; a name means the same workspace in every script."""
    flags: dict[str, FlagState] = field(default_factory=dict)
    holds: dict[str, Hold] = field(default_factory=dict)
    holds_raised: int = 0
    readings: dict[str, Reading] = field(default_factory=dict)
    contests: dict[str, Contest] = field(default_factory=dict)
    """Contests by component (semantics 2.5)."""
    out_of_service: dict[str, OutOfService] = field(default_factory=dict)
    """By component; it gets no goal (semantics 7.5)."""
    released: dict[str, tuple[str, ...]] = field(default_factory=dict)
    """By digests of generated scripts: digests of the cells for which each is released (semantics
    6.10)."""
    done_once: dict[str, str] = field(default_factory=dict)
    """Arguments of the last attempt of each task (`same_task`), if it succeeded since Stopped
    (semantics 5.1)."""

    def __post_init__(self) -> None:
        """Begin with an empty belt, and state topics without a value."""
        for number in range(1, self.cell.conveyor.sections + 1):
            self.sections[number] = SectionState(number)
        for name, component in self.cell.components.items():
            self.readings[name] = Reading(ready=component.state is None)

    def script(self, job: str) -> Script:
        """Return the script of a live job."""
        return self.jobs[job].job.script

    @property
    def on_the_line(self) -> list[JobState]:
        """The jobs that have started and not ended."""
        return list(self.jobs.line.values())

    @property
    def queue(self) -> list[JobState]:
        """The jobs that have not started, in order."""
        return self.jobs.queue()

    @property
    def has_work(self) -> bool:
        """Tell whether any job is on the line, or allowed to be."""
        return self.jobs.any_allowed

    def task(self, key: TaskKey) -> Task | None:
        """Return the task that a key names; None for the belt's own move."""
        return None if key.job is None else self.script(key.job).tasks[key.task]

    def round(self, key: TaskKey) -> int:
        """Return which further round of its repeat a task is in; 0: the first pass, or none."""
        if key.job is None or key.section is None:
            return 0
        repeat = self.script(key.job).repeat_of.get(key.task)
        cycle = self.sections[key.section].cycle
        return cycle.rounds.get(repeat.name, 0) if repeat and cycle else 0

    def phase(self, key: TaskKey) -> Phase | None:
        """Return where a task stands; None: new."""
        found = self.tasks.get(key)
        return found.phase if found else None

    @property
    def move(self) -> TaskState | None:
        """The belt's own move, if one was begun in this beat."""
        return self.tasks.get(INDEX_KEY)

    @property
    def wish(self) -> Wish | None:
        """An operator's wish that the cell stops, now or later; only a start ends it (7.2)."""
        return self.stopped_by or self.stop_after_by

    @property
    def pauses(self) -> list[Hold]:
        """The holds under which nothing starts anywhere, not even in a cycle in progress."""
        return [hold for hold in self.holds.values() if hold.is_pause]

    @property
    def works(self) -> bool:
        """Tell whether cycles in hand go on."""
        return self.packml.works and not self.shutting_down

    def times(self, now: float) -> dict[PackmlState, float]:
        """Return the seconds spent in each state, the present stay included."""
        stay = self.packml_times.get(self.packml, 0.0) + max(0.0, now - self.packml_since)
        return {**self.packml_times, self.packml: stay}

    @property
    def next_hold(self) -> str:
        """Id of the next hold; short, because operators type it."""
        return str(self.holds_raised + 1)

    def slot(self, section: int) -> ItemState | None:
        """Return the item, or empty position, in a section's slot."""
        item = self.sections[section].slot
        return None if item is None else self.items[item]

    def scope(self, key: TaskKey) -> Scope:
        """Return what references may name for a task (semantics 6.3)."""
        assert key.job is not None
        job = self.jobs[key.job].job
        item = self.items[key.item] if key.item is not None else None
        return Scope(
            params=job.params,
            order={'id': job.id, 'quantity': job.quantity},
            item={} if item is None else {'id': item.id, 'number': item.number},
            results={} if item is None else item.results,
        )


def same_task(task: Task) -> str:
    """Return a key of a task's action and constant, without its arguments (semantics 5.1)."""
    return f'{task.action} {task.name}'


def same_args(args: Mapping[str, Any]) -> str:
    """Return a key of arguments; equal ones have equal keys."""
    return repr(sorted(args.items()))
