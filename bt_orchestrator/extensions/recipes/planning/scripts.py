"""From the plans of a recipe to a script: tasks, flags, zones and initialization."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any

from bt_orchestrator.extensions.recipes.planning.candidates import Candidate
from bt_orchestrator.extensions.recipes.planning.pieces import Choice, Pieces
from bt_orchestrator.extensions.recipes.planning.reach import Reach
from bt_orchestrator.extensions.recipes.planning.section_lists import Entry, Group, Listed, listed
from bt_orchestrator.model.cell import CONVEYOR, Cell
from bt_orchestrator.model.condition import Condition
from bt_orchestrator.model.jobs.setups import change_by, with_changes
from bt_orchestrator.model.recipe import Operation, Recipe
from bt_orchestrator.model.reference import Reference, Template
from bt_orchestrator.model.script import (
    Dependency,
    InitializationDependency,
    Release,
    Repeat,
    RunsFor,
    Script,
    SectionList,
    Step,
    Task,
    Zone,
)


class PlanWriter:
    """Writes a plan down as a script."""

    def __init__(
        self, plan: Plan, plans: Plans, cell: Cell, recipe: Recipe, without: frozenset[str]
    ) -> None:
        self._plans, self._cell, self._recipe, self._without = plans, cell, recipe, without
        self._chosen = chosen(plan, plans)
        self._values = Values(self._chosen)
        self._lists = plans.lists(plan)

    def script(self) -> Script:
        """Return the script."""
        initialization, order = self._initialization()
        script = Script(
            name=self._recipe.script,
            sections={
                number: self._section(number, section) for number, section in self._lists.items()
            },
            initialization=initialization,
            initialization_dependencies=order,
            dependencies=tuple(self._flags()),
            zones=tuple(self._zones()),
            params=self._recipe.params,
            repeats=tuple(self._repeats()),
            lots=self._recipe.lots,
            likely=self._recipe.likely,
            hold_after=self._recipe.hold_after,
            first_piece=self._recipe.first_piece,
        )
        return with_changes(script, self._cell)

    # --- lists ------------------------------------------------------------------------------

    def _section(self, number: int, section: Listed) -> SectionList:
        release = (
            Release.AFTER_LAST_CONVEYOR_TASK if section.releases_early else Release.END_OF_CYCLE
        )
        return SectionList(number, tuple(self._step(group) for group in section.groups), release)

    def _step(self, group: Group) -> Step:
        return Step(
            tuple(
                tuple(self._task(member) for entry in track for member in entry.choice.members)
                for track in group
            )
        )

    def _task(self, candidate: Candidate) -> Task:
        options: dict[str, Any] = self._values.options(candidate)
        if candidate.operation.id == self._plans.reach.line.all_leave_by:
            options['runs_for'] = RunsFor.ALL
        name, args = candidate.capability.task, self._values.args(candidate)
        return Task(
            id=candidate.operation.id,
            name=name,
            action=candidate.component.action,
            component=candidate.component.name,
            args=args,
            change=change_by(candidate.component, name, args),
            **{'timeout_s': candidate.component.timeout_s, **options},
        )

    def _repeats(self) -> Iterator[Repeat]:
        """Yield the repeats, along the belt."""
        times = {rework.operations[0]: rework.times for rework in self._recipe.reworks}
        for entry in self._listed():
            names = tuple(member.operation.id for member in entry.choice.members)
            if entry.choice.repeats:
                yield Repeat(names, times[names[0]])

    def _listed(self) -> Iterator[Entry]:
        """Yield what is in the lists, along the belt."""
        groups = (group for section in self._lists.values() for group in section.groups)
        return (entry for group in groups for track in group for entry in track)

    # --- what sections share ----------------------------------------------------------------

    def _flags(self) -> Iterator[Dependency]:
        """Yield a flag for all that a device keeps: data that travels with an item needs none."""
        kept = [held for held in self._plans.held if held.is_kept_by(self._chosen[held.giver])]
        devices = [self._chosen[held.giver].component.name for held in kept]
        members = (member for entry in self._listed() for member in entry.choice.members)
        rank = {member.operation.id: rank for rank, member in enumerate(members)}
        for held, device in zip(kept, devices, strict=True):
            flag = device if devices.count(device) == 1 else f'{device}_{held.name}'
            last = max(held.takers, key=lambda taker: rank[taker])
            capacity = self._chosen[held.giver].capability.holds[held.name]
            yield Dependency(flag.replace('.', '_'), held.giver, last, capacity)

    def _zones(self) -> Iterator[Zone]:
        """Yield the workspaces that several sections use."""
        users: dict[str, list[Candidate]] = {}
        for candidate in self._chosen.values():
            for name in candidate.component.workspaces:
                users.setdefault(name, []).append(candidate)
        for name, candidates in users.items():
            if len({candidate.section for candidate in candidates}) > 1:
                yield Zone(name, tuple(candidate.operation.id for candidate in candidates))

    # --- initialization ---------------------------------------------------------------------

    def _initialization(
        self,
    ) -> tuple[tuple[Task, ...], tuple[InitializationDependency, ...]]:
        """Prepare the belt, the components that are used, and what has to be prepared before."""
        used = {CONVEYOR, *(candidate.component.name for candidate in self._chosen.values())}
        components = self._cell.components
        waiting = sorted(used)
        while waiting:
            prepare = components[waiting.pop()].prepare
            more = (
                []
                if prepare is None
                else [earlier for earlier in prepare.after if earlier not in used]
            )
            used.update(more)
            waiting += more
        tasks, order = [], []
        for name, component in components.items():
            prepare = component.prepare
            if prepare is None or name not in used or name in self._without:
                continue
            tasks.append(
                Task(
                    id=prepare.id,
                    name=prepare.task,
                    action=component.action,
                    component=name,
                    args=prepare.args,
                    **{'timeout_s': component.timeout_s, **prepare.options},
                )
            )
            order += [
                InitializationDependency(first.id, prepare.id)
                for first in (components[earlier].prepare for earlier in prepare.after)
                if first is not None
            ]
        known = {task.id for task in tasks}
        return tuple(tasks), tuple(
            dependency for dependency in order if dependency.upstream in known
        )


def chosen(plan: Plan, plans: Plans) -> dict[str, Candidate]:
    """Return the candidate of each operation, in the order of the recipe."""
    return {member.operation.id: member for choice in plans.of(plan) for member in choice.members}


# The values of a task: what a recipe names, in the names of the component that was chosen.


class Values:
    """The values of the tasks of one plan."""

    def __init__(self, chosen: Mapping[str, Candidate]) -> None:
        """Take the candidate of each operation."""
        self._chosen = chosen

    def args(self, candidate: Candidate) -> dict[str, Any]:
        """Return the goal fields of a task."""
        capability, operation = candidate.capability, candidate.operation
        fields = _copy(capability.args)
        for name, value in operation.parameters.items():
            if name in capability.parameters:  # or it is one of the alternative in `do`
                _put(fields, capability.parameters[name], self.renamed(value))
        for name, field in capability.needs.items():
            given = self._given(operation, name)
            if given is not None and field:
                _put(fields, field, Template((given,)))
        return fields

    def options(self, candidate: Candidate) -> dict[str, Any]:
        """Return the other fields of a task."""
        options = {name: self.renamed(value) for name, value in candidate.options.items()}
        given = candidate.operation.options.get('identifies')  # of a capability: a result field
        if given is not None:
            own = Reference('results', candidate.operation.id, given)
            options['identifies'] = self._in_result(own).fields
        return options

    def _given(self, operation: Operation, name: str) -> Reference | None:
        """Return what an earlier operation gives; None: the device keeps it."""
        giver = operation.needs[name]
        if name not in self._chosen[giver].capability.gives:
            return None
        return self._in_result(Reference('results', giver, (name,)))

    def renamed(self, value: Any) -> Any:
        """Return a value in which references name fields of results."""
        match value:
            case Template(parts):
                return Template(
                    tuple(
                        part if isinstance(part, str) else self._in_result(part) for part in parts
                    )
                )
            case Condition():
                return replace(
                    value,
                    value=self.renamed(value.value),
                    at_least=self.renamed(value.at_least),
                    at_most=self.renamed(value.at_most),
                    all=tuple(self.renamed(part) for part in value.all),
                    any=tuple(self.renamed(part) for part in value.any),
                )
            case Mapping():
                return {key: self.renamed(member) for key, member in value.items()}
            case list():
                return [self.renamed(member) for member in value]
        return value

    def _in_result(self, reference: Reference) -> Reference:
        if reference.source != 'results' or not reference.fields:
            return reference
        name, *path = reference.fields
        field = self._chosen[reference.name].capability.gives.get(name, name)
        return replace(reference, fields=(*field.split('.'), *path))


def _copy(args: Mapping[str, Any]) -> dict[str, Any]:
    return {
        key: _copy(value) if isinstance(value, Mapping) else value for key, value in args.items()
    }


def _put(args: dict[str, Any], field: str, value: Any) -> None:
    """Set a goal field; dots lead into nested messages."""
    *path, last = field.split('.')
    for name in path:
        args = args.setdefault(name, {})
    args[last] = value


# All plans of a recipe for a cell; a plan is a choice for every piece.

Plan = tuple[int, ...]
"""By piece: the number of its choice."""


class Plans:
    """All plans of a recipe for a cell."""

    def __init__(
        self, reach: Reach, move_us: int, *, moved: Callable[[Choice], int] = lambda _: 0
    ) -> None:
        """Take the choices that are within reach.

        :param moved: how many operations of a choice are elsewhere than before
        """
        self.pieces: Pieces = reach.pieces
        self.reach = reach
        self.held = reach.held
        self.move_us = move_us
        self.choices = [
            [way for way in ways if way.section in within]
            for ways, within in zip(self.pieces.choices, reach.sections, strict=True)
        ]
        self.moved = [[moved(way) for way in ways] for ways in self.choices]
        self.shared = self._find_shared()
        """The things that components of several sections may use; the closed form is a bound then.
        """

    def _find_shared(self) -> list[str]:
        where: dict[str, set[int]] = {CONVEYOR: {0}}
        for choice in (way for ways in self.choices for way in ways):
            for name in choice.spaces:
                where.setdefault(name, set()).add(choice.section)
        return sorted(name for name, sections in where.items() if len(sections) > 1)

    def of(self, plan: Plan) -> list[Choice]:
        """Return the choices of a plan, by piece."""
        return [ways[number] for ways, number in zip(self.choices, plan, strict=True)]

    def lists(self, plan: Plan) -> dict[int, Listed]:
        """Return the lists of a plan, by section, along the belt."""
        entries: dict[int, list[Entry]] = {}
        for piece, choice in enumerate(self.of(plan)):
            entries.setdefault(choice.section, []).append(Entry(piece, choice))
        return {section: listed(self.pieces, entries[section]) for section in sorted(entries)}
