"""The cell: what exists, as the cell file says it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

from bt_orchestrator.model.fault import Fault
from bt_orchestrator.model.goal import RESULT_TIMEOUT_S

DEFAULT_TIMEOUT_S = 300.0
"""Seconds that a task may take unless it or its component says otherwise (semantics 2.4)."""

DEFAULT_DURATION_S = 1.0
"""Seconds that a simulated task takes without a nominal duration (formats: cell file)."""

MOST_ITEMS = 10_000
"""Most items of one order unless the cell file says otherwise (semantics 6.6)."""

CONVEYOR = 'conveyor'
"""Name under which the conveyor appears among the components."""


class OnFailure(Enum):
    """The consequence of a task's last failed attempt (semantics 2.7)."""

    HOLD = 'hold'
    CONTINUE = 'continue'
    REJECT = 'reject'
    ABORT_JOB = 'abort_job'


@dataclass(frozen=True)
class HoldAfter:
    """How many rejects among how many items hold the line (semantics 7.7)."""

    rejects: int
    of: int
    """Items that were begun one after the other."""


class Release(Enum):
    """Whether a generated script has to be released before it starts (semantics 6.10)."""

    ENGINEER = 'engineer'
    """An engineer releases it."""
    AUTOMATIC = 'automatic'
    """It starts without anybody's release."""


class Approval(Enum):
    """The approval that the first piece of a job needs, where an order asks for it (6.12)."""

    ENGINEER = 'engineer'
    OPERATE = 'operate'
    """An operator's, or an engineer's."""
    AUTOMATIC = 'automatic'
    """No job waits for an approval."""


class Start(Enum):
    """The meaning of the `start` of a work order (semantics 6.7)."""

    BINDING = 'binding'
    """The job does not start before it."""
    ADVISORY = 'advisory'
    """It only helps to find the job's place in the queue."""


@dataclass(frozen=True)
class StateTopic:
    """A topic on which a component says whether it may be sent a goal (semantics 2.5)."""

    topic: str
    type: str
    field: str
    ready: tuple[Any, ...]
    """Values of the field that allow a goal."""

    def __str__(self) -> str:
        return f'{self.topic} = {" or ".join(str(value) for value in self.ready)}'


WITHIN_S = 0.5
"""Longest time between two messages of a safety input unless the cell file says otherwise."""


@dataclass(frozen=True)
class SafetyInput(StateTopic):
    """A topic that says whether goals may be sent at all (semantics 7.9); no safety function."""

    within_s: float = WITHIN_S
    """Its last message is older at no time, seconds."""


@dataclass(frozen=True)
class Setup:
    """One thing of a component that tasks need in one of several ways (semantics 5.3)."""

    values: Mapping[str, Any]
    """The argument of the change to each value, by the name of the value."""
    task: str
    """Task constant, or label, of the change."""
    argument: str
    """Goal field that takes the value."""
    reads: str = ''
    """Field of the state topic that tells the value, or a path to it; empty: no field does."""
    read_as: Mapping[str, Any] = field(default_factory=dict)
    """The content of that field for each value, by the name of the value."""

    @property
    def unset(self) -> Any:
        """The content of that field in a new message."""
        return type(next(iter(self.read_as.values())))()

    def told(self, reading: Any) -> str:
        """Return the value that the field tells; what is no value of the setup, as a text."""
        same = (
            name
            for name, value in self.read_as.items()
            if (type(value), value) == (type(reading), reading)
        )
        return next(same, str(reading))


@dataclass(frozen=True)
class Component:
    """One device controller with one ROS 2 action server."""

    name: str
    sections: tuple[int, ...]
    """Sections that it belongs to, ascending; empty for a component of no section."""
    action: str
    type: str
    state: StateTopic | None = None
    timeout_s: float | None = DEFAULT_TIMEOUT_S
    """Default for its tasks; None: no limit."""
    durations_s: Mapping[str, float] = field(default_factory=dict)
    """Nominal seconds of each task, for simulation and prediction."""
    default_duration_s: float = DEFAULT_DURATION_S
    result_timeout_s: float = RESULT_TIMEOUT_S
    """Seconds for which its server remembers a goal that ended (semantics 9.2)."""
    results: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    """Simulated result fields of each task."""
    faults: tuple[Fault, ...] = ()
    """Faults of the simulated controller."""
    capabilities: Mapping[str, Capability] = field(default_factory=dict)
    """The capabilities that recipes may use, by name."""
    workspaces: tuple[str, ...] = ()
    """Spaces in which it works; empty: that of its section, shared with all others there."""
    prepare: Preparation | None = None
    """Its initialization in generated scripts."""
    setups: Mapping[str, Setup] = field(default_factory=dict)
    """By name."""

    def duration_s(self, task_name: str) -> float:
        """Nominal seconds of a task."""
        return self.durations_s.get(task_name, self.default_duration_s)


@dataclass(frozen=True)
class Conveyor:
    """The indexing belt: how many positions it has and which goal moves it by one."""

    sections: int
    component: Component
    """Its controller, a component of no section."""
    task: str
    """Task constant of one index move; a label where the type has no task field."""
    retries: int = 0
    on_failure: OnFailure = OnFailure.HOLD


@dataclass(frozen=True)
class Cell:
    """One robotic cell: a belt and the components along it."""

    name: str
    conveyor: Conveyor
    components: Mapping[str, Component]
    """By name, the conveyor among them."""
    start: Start = Start.BINDING
    """The meaning of the `start` of a work order here."""
    release: Release = Release.ENGINEER
    """The person or rule that releases generated scripts."""
    most_items: int = MOST_ITEMS
    """Most items of one order. It changes no goal, so it is no part of the digest."""
    hold_after: HoldAfter | None = None
    """For scripts without a limit of their own. It is no part of the digest either."""
    safety: SafetyInput | None = None
    """None: goals are sent without one."""
    first_piece: Approval = Approval.ENGINEER
    """The approval of first pieces. It is no part of the digest either."""

    def by_action(self, action: str) -> Component | None:
        """Return the component that serves an action name."""
        return next((c for c in self.components.values() if c.action == action), None)


# The capabilities of the components of a cell: templates of tasks, for generated scripts.

OF_TASK: Mapping[str, bool] = {'of_task': True}
"""Marks a field with values of fields of `model.script.Task`, by their names."""


@dataclass(frozen=True)
class Capability:
    """One thing that a component can do: a task, and which of its fields a recipe may name."""

    name: str
    task: str
    """Task constant of the action's Goal; a label where the type has no task field."""
    args: Mapping[str, Any] = field(default_factory=dict)
    """Goal fields that are always the same."""
    parameters: Mapping[str, str] = field(default_factory=dict)
    """Goal field of each parameter that an operation sets."""
    gives: Mapping[str, str] = field(default_factory=dict)
    """Result field of each thing that it tells later operations."""
    needs: Mapping[str, str] = field(default_factory=dict)
    """Goal field of each thing that an earlier operation has to tell it."""
    holds: Mapping[str, int] = field(default_factory=dict)
    """Things that the device itself keeps, and for how many items; they are in no result."""
    options: Mapping[str, Any] = field(default_factory=dict, metadata=OF_TASK)
    """Values of further fields of `model.script.Task`; only of those that were written."""


@dataclass(frozen=True)
class Preparation:
    """Initialization of a component: a task of every generated script that uses it."""

    id: str
    task: str
    """Task constant, or label, as in a capability."""
    after: tuple[str, ...] = ()
    """Components, the conveyor among them, whose preparation is done before."""
    args: Mapping[str, Any] = field(default_factory=dict)
    options: Mapping[str, Any] = field(default_factory=dict, metadata=OF_TASK)
    """Values of further fields of `model.script.Task`; only of those that were written."""
