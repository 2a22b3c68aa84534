"""From a plan to a script: tasks, flags, zones and initialization."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from bt_orchestrator.extensions.recipes.planning.candidates import Candidate
from bt_orchestrator.extensions.recipes.planning.plans import Plan, Plans
from bt_orchestrator.extensions.recipes.planning.section_lists import Entry, Group, Listed
from bt_orchestrator.extensions.recipes.planning.values import Values
from bt_orchestrator.model.cell import CONVEYOR, Cell
from bt_orchestrator.model.jobs.setups import change_by, with_changes
from bt_orchestrator.model.recipe import Recipe
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
            sections={number: self._section(number, one) for number, one in self._lists.items()},
            initialization=initialization,
            initialization_dependencies=order,
            dependencies=tuple(self._flags()),
            zones=tuple(self._zones()),
            params=self._recipe.params,
            repeats=tuple(self._repeats()),
            lots=self._recipe.lots,
            likely=self._recipe.likely,
        )
        return with_changes(script, self._cell)

    # --- lists ------------------------------------------------------------------------------

    def _section(self, number: int, one: Listed) -> SectionList:
        release = Release.AFTER_LAST_CONVEYOR_TASK if one.releases_early else Release.END_OF_CYCLE
        return SectionList(number, tuple(self._step(group) for group in one.groups), release)

    def _step(self, group: Group) -> Step:
        return Step(
            tuple(
                tuple(self._task(member) for entry in track for member in entry.choice.members)
                for track in group
            )
        )

    def _task(self, one: Candidate) -> Task:
        options: dict[str, Any] = self._values.options(one)
        if one.operation.id == self._plans.reach.line.all_leave_by:
            options['runs_for'] = RunsFor.ALL
        name, args = one.capability.task, self._values.args(one)
        return Task(
            id=one.operation.id,
            name=name,
            action=one.component.action,
            component=one.component.name,
            args=args,
            change=change_by(one.component, name, args),
            **{'timeout_s': one.component.timeout_s, **options},
        )

    def _repeats(self) -> Iterator[Repeat]:
        """Yield the repeats, along the belt."""
        times = {one.operations[0]: one.times for one in self._recipe.reworks}
        for one in self._listed():
            names = tuple(member.operation.id for member in one.choice.members)
            if one.choice.repeats:
                yield Repeat(names, times[names[0]])

    def _listed(self) -> Iterator[Entry]:
        """Yield what is in the lists, along the belt."""
        groups = (group for one in self._lists.values() for group in one.groups)
        return (entry for group in groups for track in group for entry in track)

    # --- what sections share ----------------------------------------------------------------

    def _flags(self) -> Iterator[Dependency]:
        """Yield a flag for all that a device keeps: data that travels with an item needs none."""
        kept = [one for one in self._plans.held if one.is_kept_by(self._chosen[one.giver])]
        devices = [self._chosen[one.giver].component.name for one in kept]
        members = (member for entry in self._listed() for member in entry.choice.members)
        rank = {member.operation.id: rank for rank, member in enumerate(members)}
        for one, device in zip(kept, devices, strict=True):
            flag = device if devices.count(device) == 1 else f'{device}_{one.name}'
            last = max(one.takers, key=lambda taker: rank[taker])
            capacity = self._chosen[one.giver].capability.holds[one.name]
            yield Dependency(flag.replace('.', '_'), one.giver, last, capacity)

    def _zones(self) -> Iterator[Zone]:
        """Yield the workspaces that several sections use."""
        users: dict[str, list[Candidate]] = {}
        for one in self._chosen.values():
            for name in one.component.workspaces:
                users.setdefault(name, []).append(one)
        for name, found in users.items():
            if len({one.section for one in found}) > 1:
                yield Zone(name, tuple(one.operation.id for one in found))

    # --- initialization ---------------------------------------------------------------------

    def _initialization(
        self,
    ) -> tuple[tuple[Task, ...], tuple[InitializationDependency, ...]]:
        """Prepare the belt, the components that are used, and what has to be prepared before."""
        used = {CONVEYOR, *(one.component.name for one in self._chosen.values())}
        components = self._cell.components
        waiting = sorted(used)
        while waiting:
            prepare = components[waiting.pop()].prepare
            more = [] if prepare is None else [one for one in prepare.after if one not in used]
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
                for first in (components[one].prepare for one in prepare.after)
                if first is not None
            ]
        known = {task.id for task in tasks}
        return tuple(tasks), tuple(one for one in order if one.upstream in known)


def chosen(plan: Plan, plans: Plans) -> dict[str, Candidate]:
    """Return the candidate of each operation, in the order of the recipe."""
    return {one.operation.id: one for choice in plans.of(plan) for one in choice.members}
