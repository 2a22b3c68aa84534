"""The script: how one product is made, read and bound to a cell."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from enum import Enum
from functools import cached_property
from typing import Any

from bt_orchestrator.model.cell import DEFAULT_TIMEOUT_S, Cell, HoldAfter, OnFailure
from bt_orchestrator.model.condition import Condition
from bt_orchestrator.model.frozen import worked_out
from bt_orchestrator.model.reference import Reference, Template, references

INDEX = 'index'
"""Reserved task id of the belt's own move (formats: events)."""

MANUAL = 'manual'
"""Task id of a goal of manual mode, which is of no job either (semantics 7.11)."""


GOES_ON = (OnFailure.CONTINUE, OnFailure.REJECT)
"""Policies with which the line goes on by itself after the last failed attempt."""


class RunsFor(Enum):
    """For which items a task runs (semantics 6.4)."""

    GOOD = 'good'
    REJECTED = 'rejected'
    ALL = 'all'

    def includes(self, rejected: bool) -> bool:
        """Tell whether a task with this setting runs for a rejected, or a good, item."""
        return self is RunsFor.ALL or (self is RunsFor.REJECTED) == rejected


class Release(Enum):
    """When a section's turn is complete (semantics 3.8)."""

    END_OF_CYCLE = 'end_of_cycle'
    AFTER_LAST_CONVEYOR_TASK = 'after_last_conveyor_task'


@dataclass(frozen=True)
class SetupChange:
    """The setup that a task gives its component (semantics 5.3)."""

    setup: str
    value: str
    implied: bool = False
    """It follows from what other tasks ask for; the text of the script does not have it."""
    on_demand: bool = False
    """Implied, and done only on the answer `change`: a task of the script changes it before."""


@dataclass(frozen=True)
class Task:
    """One goal to one action server (semantics 1 and 2)."""

    id: str
    name: str
    """Task constant of the action's Goal; a label where the type has no task field."""
    action: str
    component: str
    """Name of the component that serves the action."""
    args: Mapping[str, Any] = field(default_factory=dict)
    """Goal fields; strings with references are Templates."""
    requires_conveyor: bool = True
    qty_change: int = 0
    on_failure: OnFailure = OnFailure.HOLD
    retries: int = 0
    retry_delay_s: float = 0.0
    timeout_s: float | None = DEFAULT_TIMEOUT_S
    """The task's own, else its component's; None: no limit (semantics 2.4)."""
    condition: Condition | None = None
    """Of `when` or `unless`: whether it runs (semantics 6.5)."""
    fails_unless: Condition | None = None
    """Its verdict: what has to hold of its results (semantics 2.8)."""
    identifies: tuple[str, ...] = ()
    """Path of the result field that is the item's serial (semantics 6.8); empty: none is."""
    runs_for: RunsFor = RunsFor.GOOD
    repeatable: bool = False
    """Doing it twice does no harm (semantics 2.6, 9.2)."""
    once: bool = False
    """Initialization only: skipped if it succeeded since the cell left Stopped (semantics 5.1)."""
    setup: Mapping[str, str] = field(default_factory=dict)
    """Values of setups that its component must have (semantics 5.3)."""
    change: SetupChange | None = None
    """The setup that it changes; None: none."""

    @property
    def is_implied(self) -> bool:
        """Tell whether it is a change that the text of the script does not have."""
        return self.change is not None and self.change.implied

    @property
    def comparisons(self) -> Iterator[Condition]:
        """Every comparison of a value in its condition and its verdict."""
        for condition in self._conditions:
            yield from condition.comparisons

    @property
    def references(self) -> Iterator[Reference]:
        """Every reference to what has to be known when it starts; not to its own results."""
        yield from references(self.args)
        for condition in self._conditions:
            yield from (
                reference for reference in condition.references if not self.gives(reference)
            )

    def gives(self, reference: Reference) -> bool:
        """Tell whether a reference names one of its own results."""
        return (reference.source, reference.name) == ('results', self.id)

    @property
    def fails_by_itself(self) -> bool:
        """Tell whether a failure is in the ordinary course: a verdict, or the line goes on."""
        return self.fails_unless is not None or self.on_failure in GOES_ON

    @property
    def _conditions(self) -> Iterator[Condition]:
        return (
            condition for condition in (self.condition, self.fails_unless) if condition is not None
        )

    @cached_property
    def own_serial(self) -> Reference | None:
        """The result that is the item's serial (semantics 6.8)."""
        return Reference('results', self.id, self.identifies) if self.identifies else None

    @cached_property
    def refers(self) -> bool:
        """Tell whether it names values of the item or the order."""
        return any(True for _ in self.references)


def index_task(cell: Cell) -> Task:
    """Return the belt's own move as a task; it stands in no script."""
    conveyor = cell.conveyor
    return Task(
        id=INDEX,
        name=conveyor.task,
        action=conveyor.component.action,
        component=conveyor.component.name,
        retries=conveyor.retries,
        on_failure=conveyor.on_failure,
        timeout_s=conveyor.component.timeout_s,
    )


def manual_task(cell: Cell, component: str, name: str, args: Mapping[str, Any]) -> Task:
    """Return a goal of manual mode as a task; it stands in no script, and fails by itself."""
    made = cell.components[component]
    return Task(
        id=MANUAL,
        name=name,
        action=made.action,
        component=component,
        args=args,
        on_failure=OnFailure.CONTINUE,
        timeout_s=made.timeout_s,
    )


@dataclass(frozen=True)
class Step:
    """One task, or a parallel group of tracks that ends when all of them ended (semantics 3.1)."""

    tracks: tuple[tuple[Task, ...], ...]
    """Each track is run in order, side by side with the others."""

    @worked_out
    def tasks(self) -> tuple[Task, ...]:
        """All tasks, in the order written."""
        return tuple(task for track in self.tracks for task in track)

    @cached_property
    def requires_conveyor(self) -> bool:
        """Tell whether the belt must rest; a group does if any member does (semantics 3.3)."""
        return any(task.requires_conveyor for task in self.tasks)

    @property
    def is_group(self) -> bool:
        """Tell whether it was written as a parallel group; a repeat alone is one track."""
        return len(self.tracks) > 1


@dataclass(frozen=True)
class Repeat:
    """A track, or a step of tasks in order, that is done again after a refused result (3.9)."""

    tasks: tuple[str, ...]
    """Ids, in order; the first one names it."""
    times: int
    """Further rounds at most, unless an operator adds one."""

    @property
    def name(self) -> str:
        """Its first task."""
        return self.tasks[0]

    def __str__(self) -> str:
        return f'{", ".join(self.tasks)}: {self.rounds}'

    @property
    def rounds(self) -> str:
        """How many more there may be, in words."""
        return f'up to {self.times} more round{"s" if self.times > 1 else ""}'


@dataclass(frozen=True)
class SectionList:
    """The task list of one section."""

    section: int
    steps: tuple[Step, ...]
    release: Release = Release.END_OF_CYCLE

    @worked_out
    def tasks(self) -> tuple[Task, ...]:
        """All tasks, in the order written."""
        return tuple(task for step in self.steps for task in step.tasks)

    @cached_property
    def turn_steps(self) -> int:
        """Count the steps that must be done before the belt may move (semantics 3.8)."""
        if self.release is Release.END_OF_CYCLE:
            return len(self.steps)
        needing = [n for n, step in enumerate(self.steps, 1) if step.requires_conveyor]
        return needing[-1] if needing else len(self.steps)


@dataclass(frozen=True)
class Dependency:
    """A lateral dependency: D waits for U, through a counter (semantics 4.1)."""

    flag: str
    upstream: str
    """Id of the task that adds one after it executed."""
    downstream: str
    """Id of the task that takes one after it executed."""
    capacity: int = 1
    initial: int = 0


@dataclass(frozen=True)
class Zone:
    """Tasks that must never overlap (semantics 4.4)."""

    name: str
    tasks: tuple[str, ...]


@dataclass(frozen=True)
class InitializationDependency:
    """Order between two initialization tasks (semantics 5.1)."""

    upstream: str
    downstream: str


@dataclass(frozen=True)
class Parameter:
    """Something that a work order may set."""

    name: str
    type: str
    """One of str, int, float, bool."""
    default: Any = None
    required: bool = True


@dataclass(frozen=True)
class MadeFrom:
    """The source of a generated script; written by hand, it has none."""

    recipe: str
    version: int
    recipe_digest: str = ''
    cell_digest: str = ''
    overrides_digest: str = ''
    """Empty: there were none."""
    text_digest: str = ''
    """Of the file without this key, as it was generated; it tells what was edited since."""
    generator: str = ''
    """Version of the program."""
    without: tuple[str, ...] = ()
    """Components out of service that could have done one of its operations."""

    def says_the_same(self, other: MadeFrom | None) -> bool:
        """Tell whether both name the same recipe, cell, overrides and components in service."""
        if other is None or not self.recipe_digest or not self.cell_digest:
            return False
        names = ('recipe', 'recipe_digest', 'cell_digest', 'overrides_digest', 'without')
        return all(getattr(self, name) == getattr(other, name) for name in names)


@dataclass(frozen=True)
class Likely:
    """How often a task runs, and how often it fails, by experience (semantics 8.4)."""

    runs: float | None = None
    """Share of the good items for which its condition lets it run; None: not known."""
    fails: float | None = None
    """Share of its attempts that fail, or whose results its verdict refuses; None: not known."""


@dataclass(frozen=True)
class Script:
    """How one product is made, bound to a cell: every action names an existing component."""

    name: str
    sections: Mapping[int, SectionList]
    """By section number; sections without tasks are absent."""
    initialization: tuple[Task, ...] = ()
    initialization_dependencies: tuple[InitializationDependency, ...] = ()
    dependencies: tuple[Dependency, ...] = ()
    zones: tuple[Zone, ...] = ()
    params: Mapping[str, Parameter] = field(default_factory=dict)
    quantity: int | None = None
    """Default for orders that name none."""
    repeats: tuple[Repeat, ...] = ()
    made_from: MadeFrom | None = None
    """Where it comes from; changes nothing of what it does, nor its digest."""
    lots: Mapping[str, Template] = field(default_factory=dict)
    """The lots that go into each item, by name: texts that refer to the order (semantics 6.9)."""
    likely: Mapping[str, Likely] = field(default_factory=dict)
    """By the id of the task; changes nothing of what it does, nor its digest."""
    hold_after: HoldAfter | None = None
    """None: as the cell says (semantics 7.7)."""
    first_piece: bool = False

    @cached_property
    def source(self) -> int:
        """The section that places items (semantics 3.2)."""
        return next(s for s, tasks in self.sections.items() if _changes(tasks, 1))

    @cached_property
    def sink(self) -> int:
        """The section that takes items out (semantics 3.2)."""
        return max(s for s, tasks in self.sections.items() if _changes(tasks, -1))

    @cached_property
    def last_before_sink(self) -> int:
        """The section whose cycle makes an item processed (semantics 6.2).

        The last one before the sink; the sink itself where there is no other.
        """
        return max((s for s in self.sections if s < self.sink), default=self.sink)

    @cached_property
    def tasks(self) -> Mapping[str, Task]:
        """All tasks by id, initialization included."""
        listed = (task for tasks in self.sections.values() for task in tasks.tasks)
        return {task.id: task for task in (*self.initialization, *listed)}

    def section_of(self, task: str) -> int:
        """Return the section whose list holds a task; 0 for an initialization task."""
        return self._section_of.get(task, 0)

    @cached_property
    def _section_of(self) -> Mapping[str, int]:
        return {t.id: n for n, tasks in self.sections.items() for t in tasks.tasks}

    def step_of(self, task: str) -> Step:
        """Return the step of a section's list that holds a task."""
        return self._step_of[task]

    @cached_property
    def _step_of(self) -> Mapping[str, Step]:
        steps = (step for tasks in self.sections.values() for step in tasks.steps)
        return {task.id: step for step in steps for task in step.tasks}

    @cached_property
    def repeat_of(self) -> Mapping[str, Repeat]:
        """The repeat that a task is in, by its id."""
        return {task: repeat for repeat in self.repeats for task in repeat.tasks}

    @cached_property
    def places_of_work(self) -> Mapping[tuple[str, int], int]:
        """How many tasks each component has in each section; 0 stands for initialization."""
        return Counter((t.component, self.section_of(t.id)) for t in self.tasks.values())

    @cached_property
    def upstream_of(self) -> Mapping[str, tuple[Dependency, ...]]:
        """Dependencies by the id of their upstream task."""
        return _grouped(self.dependencies, 'upstream')

    @cached_property
    def downstream_of(self) -> Mapping[str, tuple[Dependency, ...]]:
        """Dependencies by the id of their downstream task."""
        return _grouped(self.dependencies, 'downstream')

    @cached_property
    def zones_of(self) -> Mapping[str, tuple[str, ...]]:
        """Names of the zones that each task is in, by task id."""
        zones: dict[str, tuple[str, ...]] = {}
        for zone in self.zones:
            for task in zone.tasks:
                zones[task] = (*zones.get(task, ()), zone.name)
        return zones

    def work_out(self) -> None:
        """Work out all that is asked of it: it is kept, and goes along to another process."""
        for name, member in vars(Script).items():
            if isinstance(member, cached_property):
                getattr(self, name)


def _changes(tasks: SectionList, qty_change: int) -> bool:
    return any(task.qty_change == qty_change for task in tasks.tasks)


def _grouped(flags: tuple[Dependency, ...], end: str) -> Mapping[str, tuple[Dependency, ...]]:
    groups: dict[str, tuple[Dependency, ...]] = {}
    for dependency in flags:
        task = getattr(dependency, end)
        groups[task] = (*groups.get(task, ()), dependency)
    return groups
