"""The state of a cell, and its holds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from bt_orchestrator.model.by import Control
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.events import INDEX_KEY, MANUAL_KEY, TaskKey
from bt_orchestrator.model.goal import Contest
from bt_orchestrator.model.jobs.initialization import Preparation
from bt_orchestrator.model.judging.used_ids import UsedIds
from bt_orchestrator.model.packml import PackmlState, UnitMode
from bt_orchestrator.model.reference import Scope
from bt_orchestrator.model.script import Script, Task, manual_task
from bt_orchestrator.model.state.job_state import ItemState, JobState
from bt_orchestrator.model.state.line import (
    FlagState,
    KnownSetup,
    ManualRun,
    OutOfService,
    Phase,
    Reading,
    RejectCount,
    SectionState,
    TaskState,
)
from bt_orchestrator.model.state.live_jobs import LiveJobs
from bt_orchestrator.model.stop_reason import (
    NAMED,
    TOO_MANY_REJECTS,
    UNSEEN,
    StopReason,
    Wish,
)
from bt_orchestrator.model.uptime import ClockReading
from bt_orchestrator.model.words import Words

DERIVED: Mapping[str, bool] = {'derived': True}
"""Marks a field of the state that follows from the others, or from the cell file."""


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
    clock: ClockReading | None = None
    """The last reading of wall clock and uptime that is on record; None: there is none."""
    seq: int = 0
    """Last event applied."""
    packml: PackmlState = PackmlState.STOPPED
    control: Control = Control.REMOTE
    """From where the line may be moved (semantics 7.8)."""
    unit_mode: UnitMode = UnitMode.PRODUCTION
    """In manual the cell stands, and runs single goals (semantics 7.11)."""
    manual: ManualRun | None = None
    """The last goal of manual mode; None: there was none since it was entered."""
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
    clock_set_s: float = 0.0
    """By how much the clock was set since the journal began, in seconds forward."""
    stop_reason: StopReason | None = None
    stop_message: str = ''
    """The stop reason in words."""
    shutting_down: bool = False
    """The orchestrator is shutting down; the next one continues."""
    signatures: dict[str, int] = field(default_factory=dict)
    """The last number of each key that has signed a request, by its public part (7.12)."""
    unsafe: str = ''
    """Why the safety input is not ready (semantics 7.9); empty: it is, or there is none."""
    barred: bool = False
    """Nothing starts: the orchestrator is shutting down, or the safety input is not ready."""
    belt_seq: int = 0
    """Last event that changed the content of the belt."""
    beat: int = 1
    indexing: bool = False
    """True from `belt.index_started` to `belt.indexed`."""
    sections: dict[int, SectionState] = field(default_factory=dict)
    scripts: dict[str, Script] = field(default_factory=dict)
    """By digest; those that a live job uses."""
    preparations: dict[str, Preparation] = field(default_factory=dict, metadata=DERIVED)
    """The meaning of initialization in this cell, by digest."""
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
    """The person who requested that; None: not requested."""
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
    released_scripts: dict[str, Script] = field(default_factory=dict)
    """Of these, by digest: those that orders by recipe used, the last one at the end (semantics
    6.11)."""
    done_once: dict[str, str] = field(default_factory=dict)
    """Arguments of the last attempt of each task (`same_task`), if it succeeded since Stopped
    (semantics 5.1)."""
    setups: dict[str, dict[str, KnownSetup]] = field(default_factory=dict)
    """The known setups of components, by name; a component without any is left out (semantics
    5.3)."""
    reject_counts: dict[str, RejectCount] = field(default_factory=dict)
    """By the name of the script that has a limit; empty: of all others (semantics 7.7)."""
    setups_told: dict[str, dict[str, str]] = field(default_factory=dict)
    """The words of state topics about setups, by component and setup; without unknown ones."""

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
        job = key.job  # without `script`: a task is looked up eight times an attempt
        if job is not None:
            return self.jobs[job].job.script.tasks[key.task]
        run = self.manual if key == MANUAL_KEY else None
        return manual_task(self.cell, run.component, run.name, run.args) if run else None

    def round(self, key: TaskKey) -> int:
        """Return which further round of its repeat a task is in; 0: the first pass, or none."""
        if key.job is None or key.section is None:
            return 0
        repeat = self.script(key.job).repeat_of.get(key.task)
        cycle = self.sections[key.section].cycle
        return cycle.rounds.get(repeat.name, 0) if repeat and cycle else 0

    def phase(self, key: TaskKey) -> Phase | None:
        """Return where a task stands; None: new."""
        task = self.tasks.get(key)
        return task.phase if task else None

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
        """The holds that are about the whole cell, and that `resume` releases."""
        return [hold for hold in self.holds.values() if hold.is_pause]

    @property
    def stops(self) -> list[Hold]:
        """The holds under which nothing starts anywhere, not even in a cycle in progress."""
        return [hold for hold in self.pauses if hold.reason != TOO_MANY_REJECTS]

    @property
    def works(self) -> bool:
        """Tell whether cycles in hand go on."""
        return self.packml.works and not self.barred

    def times(self, now: float) -> dict[PackmlState, float]:
        """Return the seconds spent in each state, the present stay included."""
        stay = self.packml_times.get(self.packml, 0.0) + max(0.0, now - self.packml_since)
        return {**self.packml_times, self.packml: stay}

    @property
    def next_hold(self) -> str:
        """Id of the next hold; short, because operators type it."""
        return str(self.holds_raised + 1)

    @property
    def belt_carries(self) -> bool:
        """Tell whether any slot has an item or an empty position."""
        return any(section.slot is not None for section in self.sections.values())

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


# A question that waits for an operator.


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
    """The person who paused the cell; empty: not one person."""
    name: str = ''
    """Task constant; this and the following are empty, or 0, where no task is held."""
    component: str = ''
    action: str = ''
    attempt: int = 0
    """Number of the attempt that failed, from 1; 0: none was made."""
    attempts: int = 0
    """Attempts that the script allows."""
    round: int = 0
    """The number of the further round of its repeat, from 1; 0: the first pass, or no repeat."""
    message_words: tuple[Words, ...] = ()
    """Sentences of the node in the message, as facts; empty: they are known in words only."""
    controller_said: str = ''
    """Text of the controller's own result, cut."""
    last_feedback: str = ''
    """Last feedback of the failed attempt, as one JSON object."""
    topic_says: str = ''
    """In doubt after a restart: what the action's status topic says of the goal."""
    answers_together: tuple[str, ...] = ()
    """Those that one list may give to several holds (`model.requests.offers`)."""
    answers_why: str = ''
    """Why other answers are not offered; empty: nothing is left out."""
    manual: tuple[str, ...] = ()
    """Tasks that were run in manual mode on the component that it keeps, with their ends."""

    @property
    def is_pause(self) -> bool:
        """Tell whether it is about no task and no item, but about the whole cell."""
        return self.task is None and self.item is None

    @property
    def must_be_named(self) -> bool:
        """Tell whether only naming it releases it (semantics 7.3)."""
        return self.is_pause and self.reason in NAMED

    @property
    def is_unseen(self) -> bool:
        """Tell whether the cell may have been changed unseen before it (semantics 5.3)."""
        return self.is_pause and self.reason in UNSEEN

    @property
    def key(self) -> TaskKey | None:
        """The task that is held, if it is a task."""
        if self.task is None:
            return None
        return TaskKey(self.job, self.section, self.item, self.task)
