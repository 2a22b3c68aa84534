"""Events of components, holds and the cell, and operators' decisions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.events.base import Event


@dataclass(frozen=True, kw_only=True)
class ComponentStateChanged(Event):
    """The value of a state topic changed (semantics 2.5)."""

    event: ClassVar[str] = 'component.state_changed'
    component: str
    ready: bool
    value: Any = None
    """None: the publisher is gone."""


@dataclass(frozen=True, kw_only=True)
class ComponentContested(Event):
    """The contest of a component began, changed or ended (2.5)."""

    event: ClassVar[str] = 'component.contested'
    component: str
    servers: tuple[str, ...] = ()
    """All servers of its action, if there are several."""
    goals: tuple[str, ...] = ()
    """Goals there that belong to no task of the line."""


@dataclass(frozen=True, kw_only=True)
class ComponentOutOfService(Event):
    """An operator took a component out of service: it gets no goal (semantics 7.5)."""

    event: ClassVar[str] = 'component.out_of_service'
    component: str
    reason: str
    """The person who did it, and the reason."""
    jobs: tuple[str, ...] = ()
    """Queued jobs that need it; they are passed."""


@dataclass(frozen=True, kw_only=True)
class ComponentInService(Event):
    """A component is in service again; jobs that lack no other one start in their turn."""

    event: ClassVar[str] = 'component.in_service'
    component: str


@dataclass(frozen=True, kw_only=True)
class ComponentSetupLost(Event):
    """The controller of a component was started anew: its setups are not known (semantics 5.3)."""

    event: ClassVar[str] = 'component.setup_lost'
    component: str


@dataclass(frozen=True, kw_only=True)
class ComponentSetupRead(Event):
    """The state topic of a component tells another value of a setup (semantics 5.3)."""

    event: ClassVar[str] = 'component.setup_read'
    component: str
    setup: str
    """Name of the setup in the cell file."""
    value: str | None = None
    """Its value, or what the topic tells in place of one; None: the publisher is gone."""


@dataclass(frozen=True, kw_only=True)
class HoldRaised(Event):
    """Something waits for an operator (semantics 7.1)."""

    event: ClassVar[str] = 'hold.raised'
    hold: str
    job: str | None = None
    section: int | None = None
    item: str | None = None
    task: str | None = None
    name: str = ''
    """Task constant; this and the following are empty, or 0, where no task is held."""
    component: str = ''
    action: str = ''
    attempt: int = 0
    """Number of the attempt that failed, from 1; 0: none was made."""
    attempts: int = 0
    """Attempts that the script allows."""
    reason: str
    message: str = ''
    answers: tuple[str, ...] = ()
    owner: str = ''
    """The person who paused the cell; empty: not one person."""
    round: int = 0
    """The number of the further round of its repeat, from 1; 0: the first pass, or no repeat."""
    controller_said: str = ''
    """As in `task.failed`."""
    last_feedback: str = ''
    """As in `task.failed`."""
    topic_says: str = ''
    """In doubt after a restart: what the action's status topic says of the goal."""
    items: tuple[str, ...] = ()
    """The rejects of a run (semantics 7.7); empty: it is about no run."""


@dataclass(frozen=True, kw_only=True)
class HoldReleased(Event):
    """The hold is over."""

    event: ClassVar[str] = 'hold.released'
    hold: str


@dataclass(frozen=True, kw_only=True)
class OperatorEvent(Event):
    """Somebody asked for something: who, why, and about what."""

    who: str
    reason: str
    origin: str = ''
    """Where the command came from, for instance the program and the computer."""
    role: str = ''
    """The role of `who`; empty: not recorded, as in older journals."""
    known: str = ''
    """How it is known who that is, with which role; empty: not recorded."""
    claims: str = ''
    """Role that was asserted and did not count, and by what."""
    hold: str | None = None
    job: str | None = None
    item: str | None = None
    component: str | None = None
    digest: str | None = None
    """Of the script that it is about."""
    stop: str | None = None
    """Name of the stop of the line that it is about, as in `HISTORY:SEQ`."""


@dataclass(frozen=True, kw_only=True)
class OperatorDecided(OperatorEvent):
    """An operator answered or commanded something."""

    event: ClassVar[str] = 'operator.decided'
    answer: str
    code: str = ''
    """Of the plant's reason for the stop; empty: none was given."""


@dataclass(frozen=True, kw_only=True)
class OperatorRefused(OperatorEvent):
    """A command was refused; nothing was changed."""

    event: ClassVar[str] = 'operator.refused'
    command: str
    message: str
    """Why it was refused."""


@dataclass(frozen=True, kw_only=True)
class RequestRefused(Event):
    """Refused commands of one sender, counted because there were too many to record singly."""

    event: ClassVar[str] = 'request.refused'
    who: str = ''
    """Empty: of many senders, or of one without a name."""
    origin: str = ''
    """Where they came from."""
    count: int
    """How many they are."""
    since: float
    """Time of the first of them, seconds since the epoch."""
    commands: Mapping[str, int] = field(default_factory=dict)
    """How many of each command; `...`: of all others."""
    message: str = ''
    """Why the last of them was refused."""


@dataclass(frozen=True, kw_only=True)
class RequestSigned(Event):
    """A key has signed the request that is recorded next (semantics 7.12)."""

    event: ClassVar[str] = 'request.signed'
    key: str
    """Its name in the file of users."""
    public: str
    """Its public part, base64."""
    number: int
    """Of the request; the key may use no lower one again."""


@dataclass(frozen=True, kw_only=True)
class OrchestratorStarted(Event):
    """An orchestrator took over the cell from its journal."""

    event: ClassVar[str] = 'orchestrator.started'
    cell: str
    digest: str
    """Of the cell's definition."""
    history: str = ''
    """Unique random id of the journal; empty: written by an older version."""
    restored: bool = False
    """All earlier events are a restored copy: the line may be ahead of it."""
    missing: str = ''
    """Events lost from the journal, in words: a file was damaged, removed or replaced, and the
    line is ahead of the journal; empty: none."""
    boot: str = ''
    """Boot id of its machine; empty: not known."""
    cell_definition: Cell | None = None
    """The cell, as its file said it; None: written by an older version."""


@dataclass(frozen=True, kw_only=True)
class OrchestratorStopping(Event):
    """The node ends: goals are cancelled, and nothing starts before another one takes over."""

    event: ClassVar[str] = 'orchestrator.stopping'


@dataclass(frozen=True, kw_only=True)
class ClockStepped(Event):
    """The wall clock, which stamps events, was set; no wait uses it but that for a start (2.4).

    This event and those after it have the new time.
    """

    event: ClassVar[str] = 'clock.stepped'
    seconds: float
    """By how much, forward; negative: back."""
    uptime: float | None = None
    """Seconds for which the machine had been up at that time, in the boot that the
    `orchestrator.started` before it names; None: not known."""


@dataclass(frozen=True, kw_only=True)
class SafetyChanged(Event):
    """The safety input became ready, or is not ready any more (semantics 7.9)."""

    event: ClassVar[str] = 'safety.changed'
    ready: bool
    reason: str = ''
    """Why it is not ready; empty: it is."""


@dataclass(frozen=True, kw_only=True)
class StopReasonChanged(Event):
    """The stop reason of the line changed; PackML and ISA-95 states follow from it (7.2)."""

    event: ClassVar[str] = 'cell.stop_reason_changed'
    stop_reason: str
    """operator, own_fault, starved, blocked or emergency; empty: it does not stand still."""
    reason: str = ''


@dataclass(frozen=True, kw_only=True)
class ControlChanged(Event):
    """The line was handed over, to its panels or back; nothing stops (semantics 7.8)."""

    event: ClassVar[str] = 'cell.control_changed'
    control: str
    """local or remote."""
    reason: str = ''


@dataclass(frozen=True, kw_only=True)
class UnitModeChanged(Event):
    """The cell is in manual mode, or in production again; nothing stops (semantics 7.11)."""

    event: ClassVar[str] = 'cell.unit_mode_changed'
    mode: str
    """production or manual."""
    reason: str = ''


@dataclass(frozen=True, kw_only=True)
class ManualAsked(Event):
    """Somebody at a panel wants a goal in manual mode; `task.started` sends it (semantics 7.11).

    From here on the setups of the component are not known, and its initialization is not done.
    """

    event: ClassVar[str] = 'manual.asked'
    component: str
    name: str
    """Task constant."""
    args: Mapping[str, Any] = field(default_factory=dict)
    who: str
    known: str
    """How it is known who that is; only the same one at a panel keeps the goal running."""
    reason: str
    hold: str = ''
    """The hold that keeps the component, and stays; empty: none does."""


@dataclass(frozen=True, kw_only=True)
class CellStateChanged(Event):
    """The cell entered another PackML state (semantics 7.2)."""

    event: ClassVar[str] = 'cell.state_changed'
    state: str
    previous: str
    cause: str = ''
    """PackML command, given or automatic, or `done`: the acting state is complete."""
    reason: str = ''
