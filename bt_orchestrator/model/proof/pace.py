"""The pace of a line in closed form: seconds from one item to the next, without a run.

The relations that decide whether a line gets stuck also decide how fast it is, if they are
weighted with durations: no line is faster than the circle of them that takes longest for each of
its beats, and one without shared spaces is exactly as fast (semantics 8.4; docs/deadlock_proof.md
says why).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import NamedTuple

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.proof.precedence import Operations, Precedence, Relation
from bt_orchestrator.model.proof.slowest_circle import Arc, ratio, slowest_circle
from bt_orchestrator.model.proof.standstill import gets_stuck
from bt_orchestrator.model.script import INDEX, Dependency, RunsFor, Script, Task, index_task

Durations = Mapping[str, int]
"""Microseconds of each task of the lists, and of the move of the belt, by id: whole numbers have
exact sums."""


NAMED = 10
"""The number of named parts of a limit; a longer one has its first and last parts named."""


@dataclass(frozen=True)
class Limit:
    """The steps that follow each other, and so limit the line."""

    tasks: tuple[str, ...]
    """In their order; the move of the belt is `INDEX`."""
    per_item_us: Fraction
    items: int = 1
    """Items that go through while all of it happens once."""
    flags: tuple[str, ...] = ()
    """Flags by which one section waits for another in it."""
    only_one: str = ''
    """The single thing, a component or a zone; empty: a circle of waits."""

    @property
    def per_item_s(self) -> float:
        """Seconds for each item."""
        return float(self.per_item_us / 1_000_000)

    def __str__(self) -> str:
        text = _named(['index move' if task == INDEX else task for task in self.tasks], ' + ')
        if self.only_one:
            return f'{text}, never two at once ({self.only_one})'
        if self.flags:
            word = 'flag' if len(self.flags) == 1 else 'flags'
            text += f' ({word} {_named(self.flags)})'
        return f'{text}, for {self.items} items' if self.items > 1 else text


def _named(names: Sequence[str], between: str = ', ') -> str:
    if len(names) > NAMED:
        names = (*names[: NAMED - 3], f'{len(names) - NAMED + 1} more', *names[-2:])
    return between.join(names) or 'nothing that takes time'


NOTHING = Limit((), Fraction(0))


@dataclass(frozen=True)
class Pace:
    """How long a line takes from one item to the next, once it is full."""

    limit: Limit
    """With every task that good items may meet."""
    least: Limit
    """Without the tasks that a condition may skip."""
    not_counted: tuple[str, ...] = ()
    """The causes that may make the line slower than that."""

    @property
    def per_item_s(self) -> float:
        """Seconds from one item to the next; see `is_exact`."""
        return self.limit.per_item_s

    @property
    def is_exact(self) -> bool:
        """Tell whether the line is exactly so fast; else it is a bound."""
        return not self.not_counted and self.least.per_item_us == self.limit.per_item_us

    @property
    def period(self) -> str:
        """Say how long it is, and how sure that is."""
        text = f'{self.per_item_s:.1f} s per item'
        if self.least.per_item_us != self.limit.per_item_us:
            text = f'{self.least.per_item_s:.1f} to {text}, depending on conditions'
        if self.not_counted:
            text += f' or longer ({", ".join(self.not_counted)} not counted)'
        return text

    def __str__(self) -> str:
        return f'pace: {self.period}, limited by {self.limit}'


def pace(script: Script, cell: Cell) -> Pace | None:
    """Return the pace of a script by the durations of a cell; None: the line gets stuck."""
    return PacedLine(script, cell).pace(cell)


class PacedLine:
    """A script whose pace is asked for with one durations after another."""

    def __init__(self, script: Script, cell: Cell) -> None:
        self._tasks = [task for tasks in script.sections.values() for task in tasks.tasks]
        self._move = index_task(cell)
        self._moves = script.source != script.sink
        """A belt on which nothing ever stands does not move (semantics 3.5)."""
        self._operations = Operations(script)
        self._precedence = Precedence([self._operations])
        self._belt = len(self._operations.all)
        """The number of the belt behind those of the operations."""
        self._contested = contested(script, self._move)
        self._repeats = script.repeats

    @property
    def flags(self) -> Mapping[str, Dependency]:
        """The flags of the script, by name."""
        return self._operations.flags

    @cached_property
    def gets_stuck(self) -> bool:
        """Tell whether some item never comes."""
        return gets_stuck(self._precedence)

    def pace(self, cell: Cell) -> Pace | None:
        """Return the pace by the durations of a cell; None: the line gets stuck."""
        if self.gets_stuck:
            return None
        us = self.durations(cell)
        skipped = {task.id: 0 for task in self._tasks if task.condition is not None}
        most = self.limit(us)
        least = self.limit({**us, **skipped}) if skipped else most
        waits = [f'waits for {name}' for name in self._contested]
        waits += [f'further rounds of {repeat.name}' for repeat in self._repeats]
        return Pace(most, least, tuple(waits))

    def limit(self, us: Durations, changed: Dependency | None = None) -> Limit:
        """Return what limits a line most that does not get stuck; of equals a circle of waits.

        :param changed: other counts of one flag
        """
        line = self._precedence
        if changed is not None:
            line = Precedence([self._operations.changed(changed)])
        circle = slowest_circle(self._belt + 1, self._arcs(line, us))
        alone = (_alone(name, tasks, us) for name, tasks in self._contested.items())
        return max([_circle(circle, us, self._belt), *alone], key=lambda limit: limit.per_item_us)

    def durations(self, cell: Cell) -> Durations:
        """Return how long everything takes with a good item."""
        durations_us = {INDEX: _us(self._move, cell) if self._moves else 0}
        for task in self._tasks:
            durations_us[task.id] = (
                _us(task, cell) if task.runs_for.includes(rejected=False) else 0
            )
        return durations_us

    def _arcs(self, line: Precedence, us: Durations) -> list[Arc]:
        """Return the relations as arcs between operations and the belt; their length is beats."""
        belt = self._belt
        arcs = [_arc(relation, us) for relations in line.after.values() for relation in relations]
        arcs += [Arc(turn.number, belt, 0, 0) for turn in line.turns]
        arcs.append(Arc(belt, belt, us[INDEX], 1, (INDEX,)))
        for operation in line.operations:
            if operation.at_rest:
                arcs.append(Arc(belt, operation.number, us[INDEX], 1, (INDEX,)))
            elif operation.follows_move:
                arcs.append(Arc(belt, operation.number, 0, 1))
        return arcs


def _arc(relation: Relation, us: Durations) -> Arc:
    weight = sum(us[task] for task in relation.tasks)
    beats = relation.items + relation.after.section - relation.before.section
    flag = '' if relation.dependency is None else relation.dependency.flag
    return Arc(relation.before.number, relation.after.number, weight, beats, relation.tasks, flag)


def _circle(arcs: Sequence[Arc], us: Durations, belt: int) -> Limit:
    """Return a circle in words.

    It begins behind the move of the belt, if that is in it, or else with the first section.
    """
    if not arcs:
        return NOTHING
    first = min(range(len(arcs)), key=lambda n: (arcs[n].start != belt, arcs[n].start))
    ordered = (*arcs[first:], *arcs[:first])
    tasks = [task for arc in ordered for task in arc.tasks if us[task]]
    if tasks[0] == INDEX:
        tasks = [*tasks[1:], INDEX]
    return Limit(
        tasks=tuple(tasks),
        per_item_us=ratio(arcs),
        items=sum(arc.length for arc in arcs),
        flags=tuple(arc.flag for arc in ordered if arc.flag),
    )


def _alone(name: str, tasks: Sequence[str], us: Durations) -> Limit:
    """Return that some tasks never overlap."""
    named = tuple(task for task in tasks if us[task])
    return Limit(named, Fraction(sum(us[task] for task in named)), only_one=name)


def _us(task: Task, cell: Cell) -> int:
    return round(cell.components[task.component].duration_s(task.name) * 1_000_000)


# The single things: components and zones for which tasks may have to wait.


class Place(NamedTuple):
    """Where a task stands; tasks of one place never run at the same time."""

    section: int
    """0 for the move of the belt."""
    step: int = 0
    track: int = 0


def contested(script: Script, move: Task) -> Mapping[str, Sequence[str]]:
    """Return the components and zones that tasks for good items may wait for, with these tasks.

    The tasks of one section follow each other, except in different tracks of a group.
    """
    users: dict[str, dict[str, Place]] = defaultdict(dict)
    users[move.component][INDEX] = Place(0)
    for task, place in _places(script):
        users[task.component][task.id] = place
        for zone in script.zones_of.get(task.id, ()):
            users[f'zone {zone}'][task.id] = place
    return {name: list(tasks) for name, tasks in users.items() if _may_meet({*tasks.values()})}


def _places(script: Script) -> Iterator[tuple[Task, Place]]:
    for section, tasks in script.sections.items():
        for number, step in enumerate(tasks.steps):
            for track, members in enumerate(step.tracks):
                for task in members:
                    if task.runs_for is not RunsFor.REJECTED:
                        yield task, Place(section, number, track)


def _may_meet(places: set[Place]) -> bool:
    """Tell whether tasks at some places may want to run at the same time."""
    sections = {place.section for place in places}
    steps = {(place.section, place.step) for place in places}
    return len(sections) > 1 or len(places) > len(steps)
