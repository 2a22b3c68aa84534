"""The status of a cell as data: what every surface shows, over any transport.

Fields are data, not sentences for one reader, except messages of rules, servers or persons. Times
are seconds since the epoch by the node's clock; durations are seconds. An empty text means that
there is none, and None that something is not known or not there.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from bt_orchestrator.model.by import Control, Role
from bt_orchestrator.model.jobs.counting import APPROVED, produced_of
from bt_orchestrator.model.jobs.isa95 import JobWord
from bt_orchestrator.model.jobs.order import MadeAnew, RecipeChoice
from bt_orchestrator.model.packml import PackmlState, UnitMode
from bt_orchestrator.model.state import Hold, PassedTask
from bt_orchestrator.model.stop_reason import StopReason, Wish
from bt_orchestrator.model.wait import Stands, Wait
from bt_orchestrator.model.words import Words


@dataclass(frozen=True)
class TaskStatus:
    """A task that has a goal in flight."""

    id: str
    """Its id in the script, or `index` for the move of the belt."""
    name: str
    """Task constant."""
    component: str
    action: str
    """ROS 2 action name."""
    attempt: int
    """Counts from 1."""
    goal: str
    """UUID of the goal."""
    started: float
    """When this attempt began."""
    expected_s: float | None = None
    """How long it took lately, or else its nominal duration."""
    feedback: str = ''
    """Last feedback message as one JSON object."""
    round: int = 0
    """The number of the further round of its repeat, from 1; 0: the first pass, or no repeat."""


@dataclass(frozen=True)
class ItemStatus:
    """An item, or the empty position where one should be."""

    id: str
    present: bool = True
    """False: an empty position (semantics 3.2)."""
    rejected: bool = False
    nonconforming: tuple[str, ...] = ()
    """Ids of the tasks that failed for it and were continued (semantics 2.7), or that an operator
    let it pass without their verdict (2.8)."""


@dataclass(frozen=True)
class FinishedCycle:
    """The last cycle that a section completed in this beat.

    It stays told until the belt has moved.
    """

    job: str
    item: str
    passed: tuple[PassedTask, ...] = ()
    failed: tuple[str, ...] = ()
    """Ids of tasks that failed and were passed all the same."""


@dataclass(frozen=True)
class SectionStatus:
    """One position of the belt and its station."""

    number: int
    """Counts from 1 in the direction of travel."""
    slot: ItemStatus | None = None
    """Item on the belt here."""
    job: str = ''
    """Job of the cycle in progress; this and the next four: empty or None without a cycle."""
    item: ItemStatus | None = None
    """Item of the cycle in progress; it may differ from the one in the slot."""
    running: tuple[TaskStatus, ...] = ()
    passed: tuple[PassedTask, ...] = ()
    failed: tuple[str, ...] = ()
    """Ids of tasks that failed, whether passed or not."""
    waits: tuple[Wait, ...] = ()
    """Why the section waits."""
    finished: FinishedCycle | None = None
    """Its work in this beat before the cycle in progress."""


@dataclass(frozen=True)
class BeltStatus:
    """The conveyor between the sections."""

    moving: bool = False
    running: tuple[TaskStatus, ...] = ()
    """The index move, while its goal is in flight."""
    waits: tuple[Wait, ...] = ()
    """Why it does not move."""


@dataclass(frozen=True)
class ComponentStatus:
    """One device controller."""

    name: str
    action: str
    """ROS 2 action name."""
    available: bool
    """Its action server is there."""
    ready: bool
    """A goal may be sent: its state topic allows it, there is no contest, and it is in service."""
    out_of_service: str = ''
    """The person who took it out of service, and the reason; empty: it is in service (semantics
    7.5)."""
    out_of_service_since: float | None = None
    """None: it is in service."""
    contested: str = ''
    """The contest, in words; no goal is sent during one (semantics 2.5)."""
    contested_words: Words | None = None
    """The contest as facts."""
    state: str = ''
    """Last value of its state topic."""
    setups: Mapping[str, str] = field(default_factory=dict)
    """Its setups with their values; empty: the value is not known (semantics 5.3)."""
    task: str = ''
    """Task that it is reserved for."""
    feedback: str = ''
    """Last feedback message as one JSON object."""


@dataclass(frozen=True)
class JobStatus:
    """One work order, queued, on the line, or ended."""

    id: str
    script: str
    """Its name."""
    state: JobWord
    """ISA-95 job state, with its substate: Interrupted/Held or Interrupted/Suspended."""
    digest: str = ''
    """Of the script."""
    recipe: str = ''
    """Name of the recipe that the script was generated from; empty: none."""
    recipe_version: int | None = None
    """Version of the recipe; None: it has none, or is not known."""
    by_recipe: bool = False
    """Its order named a recipe: it can be made anew."""
    rest_of: str = ''
    """The job whose items it makes that this had not begun (semantics 7.6); empty: none."""
    anew: MadeAnew | None = None
    """Why its script was generated again, and the pace since (semantics 7.5); None: it was not."""
    position: int = 0
    """Place in the queue, from 1; 0: it has started, or ended."""
    ending: str = ''
    """stopping or aborting: it ends when its last item has left."""
    expected_end_s: float | None = None
    """Seconds from the time of the status."""
    quantity: int = 0
    priority: int = 0
    """The higher the more urgent."""
    start: float | None = None
    """When it should begin."""
    due: float | None = None
    """When it should have ended."""
    awaits_start: bool = False
    """It may not start before `start` (semantics 6.7): AllowedToStart, but not ready."""
    awaits_release: bool = False
    """Its script was generated, and is not released (semantics 6.10): it is passed."""
    held: bool = False
    """It waits in the queue, and a person keeps it from starting."""
    unavailable: tuple[str, ...] = ()
    """Components out of service that it needs (semantics 7.5): in the queue it is passed, on the
    line its tasks wait."""
    queued_at: float = 0.0
    started_at: float | None = None
    """When it left the queue; None: it has not."""
    ended_at: float | None = None
    """When its last item had left; None: it has not ended."""
    started: int = 0
    """Source cycles begun; this and the following count items (semantics 6.2)."""
    placed: int = 0
    processed: int = 0
    packed: int = 0
    rejected: int = 0
    nonconforming: int = 0
    """Of the packed ones."""
    missing: int = 0
    initialization: tuple[str, ...] = ()
    """Ids of initialization tasks that have not succeeded yet."""
    running: tuple[TaskStatus, ...] = ()
    """Those of them that have a goal in flight."""
    passed: tuple[PassedTask, ...] = ()
    """Initialization tasks that have ended; none once the job has ended."""
    good: int = 0
    """Packed items that conformed when they left the line."""
    by_hand: int = 0
    """Missing items that were placed and then taken off by hand."""
    end_unknown: str = ''
    """Why its end cannot be expected; empty: nothing speaks against it."""
    first_piece: str = ''
    """Its first piece: it waits for the approval of that, or had it (semantics 6.12)."""
    first_piece_state: str = ''
    """approved, else how it left the line: packed, rejected, by_hand, missing; empty: not yet."""

    @property
    def unreleased(self) -> str:
        """The digest of its script, if it waits for the release of it; else empty."""
        return self.digest if self.awaits_release else ''

    @property
    def awaited_piece(self) -> str:
        """The first piece whose approval it waits for; empty: it waits for none."""
        return '' if self.first_piece_state == APPROVED else self.first_piece

    @property
    def to_begin(self) -> int:
        """Count the items that it will still begin."""
        is_over = self.ending or self.ended_at is not None
        return 0 if is_over else max(self.quantity - self.started, 0)

    @property
    def produced(self) -> int:
        """Count the items that were placed and have left the line."""
        return produced_of(self.packed, self.rejected, self.by_hand)

    @property
    def left(self) -> int:
        """Count the items that have left the line, good or bad."""
        return self.packed + self.rejected + self.missing

    @property
    def on_line(self) -> int:
        """Count the items that are on their way."""
        return max(self.started - self.left, 0)


@dataclass(frozen=True)
class ListedJob:
    """A job with all that a status leaves out of it (ISA-95: job order and job response)."""

    status: JobStatus
    params: Mapping[str, object] = field(default_factory=dict)
    """Every parameter of its script."""
    details: Mapping[str, object] = field(default_factory=dict)
    """The customer's JSON, as given."""
    reason: str = ''
    """Why it was stopped or aborted."""
    choice: RecipeChoice | None = None
    """The recipe that its order named in place of a script; None: it named a script."""


@dataclass(frozen=True)
class FlagStatus:
    """The counter of a lateral dependency (semantics 4.1)."""

    name: str
    count: int
    capacity: int


@dataclass(frozen=True)
class ManualGoal:
    """The goal of manual mode, or the last one (semantics 7.11)."""

    component: str
    task: str
    """Task constant."""
    state: str
    """running, cancelling, or how it ended: done, skipped, or the reason of the failure."""
    args: Mapping[str, object] = field(default_factory=dict)
    hold: str = ''
    """The hold that keeps the component; empty: none does."""
    who: str = ''
    reason: str = ''
    goal: str = ''
    """UUID of the goal; empty: it had none."""
    started: float = 0.0
    ended: float | None = None
    """None: it has not ended."""
    message: str = ''
    """Why it failed, in words."""
    results: Mapping[str, object] = field(default_factory=dict)


@dataclass(frozen=True)
class StandbyStatus:
    """A node that waits to take over the cell (semantics 9.4)."""

    host: str
    process: int
    trouble: str = ''
    """Why it could not take over at this moment; empty: it could."""
    seq: int = 0
    """The last event that it has seen in the journal."""


@dataclass(frozen=True)
class Leadership:
    """The node that leads the cell, and those that wait to do so (semantics 9.4)."""

    host: str
    """Of the leader."""
    process: int = 0
    """Of the leader."""
    epoch: int = 0
    """Grows with each new leader."""
    standbys: tuple[StandbyStatus, ...] = ()
    """Those that were heard, also one that has fallen silent since."""


@dataclass(frozen=True)
class CellStatus:
    """The status of one cell after an event: the only view for surfaces."""

    cell: str
    """Its name."""
    stamp: float
    """Time of the status."""
    seq: int
    """Last event contained; 0: none yet."""
    history: str
    """Journal of `seq`; if it changes, all numbers restart."""
    state: PackmlState
    """PackML state."""
    state_since: float
    """When it was entered, or the node started in it."""
    state_times: Mapping[PackmlState, float] = field(default_factory=dict)
    """Seconds in every state that the cell has been in, the present stay included."""
    stop_reason: StopReason | None = None
    """Why the line stands still: operator, own_fault, starved, blocked or emergency."""
    stop_message: str = ''
    """The stop reason in words."""
    stop_words: Words | None = None
    """The stop reason as facts; None: it is known in words only."""
    stands: Stands | None = None
    """Why nothing moves, also where nothing is held (semantics 7.4); None: something moves."""
    stop_after: str = ''
    """item or job: the line runs empty and stops."""
    wish: Wish | None = None
    """The person who requested the stop; then the cell waits for an operator's start (semantics
    7.2)."""
    waits_for: str = ''
    """Commands that let it work again, in words."""
    safety: str = ''
    """ready, or why the safety input is not (semantics 7.9); empty: the cell has none."""
    safety_words: Words | None = None
    """Why it is not ready, as facts; None: it is ready, or the reason is known in words only."""
    control: Control = Control.REMOTE
    """local: only the panels of the line may move it (semantics 7.8)."""
    unit_mode: UnitMode = UnitMode.PRODUCTION
    """manual: the cell stands, and runs single goals (semantics 7.11)."""
    manual: ManualGoal | None = None
    """The last goal of manual mode; None: there was none since it was entered."""
    unauthenticated_role: Role | None = None
    """Role of all clients in the ROS domain; None: no access over ROS, or not known."""
    signed_commands: str = ''
    """optional: unsigned requests have that role, and are unauthenticated; required: only signed
    requests count (semantics 7.12); empty: no access over ROS, or not known."""
    boot: str = ''
    """The start of the node's computer from which `uptime` counts."""
    uptime: float = 0.0
    """Seconds of the node's computer at this status; a signature names it."""
    commands: tuple[str, ...] = ()
    """PackML commands that its state allows, as verbs; those of `stop_after` always are."""
    journal_failure: str = ''
    """Why the engine has stopped; only `abort` is possible."""
    disk_wait: str = ''
    """A pending write to the disk; meanwhile nothing is sent, and commands wait."""
    belt: BeltStatus = BeltStatus()
    initialization: tuple[Wait, ...] = ()
    """Why initialization does not go on."""
    sections: tuple[SectionStatus, ...] = ()
    """In the direction of travel."""
    components: tuple[ComponentStatus, ...] = ()
    """The conveyor first."""
    jobs: tuple[JobStatus, ...] = ()
    """On the line, the first 100 of the queue in order, the last that ended."""
    queued: int = 0
    """How many jobs are in the queue, listed or not."""
    flags: tuple[FlagStatus, ...] = ()
    holds: tuple[Hold, ...] = ()
    leadership: Leadership | None = None
    """The nodes of the cell; None: no other node can take over."""


@dataclass(frozen=True)
class ComponentDescription:
    """The facts of the cell file about one device controller."""

    name: str
    action: str
    """ROS 2 action name."""
    type: str
    """ROS 2 action type."""
    sections: tuple[int, ...] = ()
    """Sections that it belongs to; empty: none, as the conveyor."""
    durations_s: Mapping[str, float] = field(default_factory=dict)
    """Nominal seconds by task constant."""
    default_duration_s: float = 0.0
    """Nominal seconds of a task that is not named there."""
    tasks: tuple[str, ...] = ()
    """Task constants of its action type; empty: it takes any label."""
    goal_fields: Mapping[str, str] = field(default_factory=dict)
    """ROS types of the fields that arguments may set, by name."""


@dataclass(frozen=True)
class CellDescription:
    """The parts of the cell: changes only when the node starts with another cell file."""

    cell: str
    sections: int
    """How many positions the belt has."""
    conveyor: str
    """Name of the component that moves the belt."""
    components: tuple[ComponentDescription, ...] = ()
