"""Recipes and cells that nobody wrote by hand, as facts; about a third cannot be made."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from itertools import pairwise
from random import Random
from typing import Any

from fakes.line import Line

from bt_orchestrator.model.cell import Capability, Cell, Component, OnFailure, Preparation
from bt_orchestrator.model.condition import Condition
from bt_orchestrator.model.recipe import Operation, Overrides, Recipe, Rework
from bt_orchestrator.model.reference import Reference, Template
from bt_orchestrator.model.script import RunsFor

line_of = cache(Line)
"""A cell with so many sections."""

TASKS = ('TASK_A', 'TASK_B', 'TASK_C')
SECONDS = (0.5, 1.0, 1.5, 2.5, 3.25, 4.0, 7.0)
SPACES = ('left', 'right', 'top')


class DrawnRecipe:
    """One recipe, and a cell that may be able to make it."""

    def __init__(
        self,
        seed: int,
        *,
        most_sections: int = 5,
        most_operations: int = 9,
        shares: bool | None = None,
        holds: bool = True,
    ) -> None:
        """Draw both.

        :param shares: whether sections share components or workspaces; None: perhaps
        :param holds: devices may keep data themselves
        """
        self._random = random = Random(seed)
        self.size = random.randint(2, most_sections)
        self._shares = random.random() < 0.4 if shares is None else shares
        self._holds = holds
        self._count = random.randint(1, most_operations)
        self._skills = [f'skill{number}' for number in range(random.randint(1, 6))]
        self._needing = self._skills[-1] if len(self._skills) > 2 else ''
        """What has to be told `size`."""
        self._free = {skill for skill in self._skills if random.random() < 0.3}
        """What needs no belt, whoever does it."""
        self._given = {skill for skill in self._skills if random.random() < 0.3}
        """What tells `size`."""
        self._held = {
            skill
            for skill in self._skills
            if holds and skill not in self._given and self._chance(0.15)
        }
        """What makes a device keep `pose`."""
        self.cell: Cell = self._cell()
        self.recipe: Recipe = self._recipe()
        self.overrides = self._overrides()

    def _chance(self, of_one: float) -> bool:
        return self._random.random() < of_one

    # --- the cell ---------------------------------------------------------------------------

    def _cell(self) -> Cell:
        cell = line_of(self.size).cell
        belt_s = {'MOVE_ONE_INDEX': self._random.choice((0.5, 2.0))}
        components = {}
        for name, device in cell.components.items():
            if name == 'conveyor':
                prepare = Preparation('home', 'HOME', options={'once': True})
                components[name] = replace(device, durations_s=belt_s, prepare=prepare)
            else:
                components[name] = self._component(device)
        conveyor = replace(cell.conveyor, component=components['conveyor'])
        return replace(cell, components=components, conveyor=conveyor)

    def _component(self, component: Component) -> Component:
        is_shared = len(component.sections) != 1
        skills = self._random.sample(
            self._skills, min(len(self._skills), self._random.randint(0, 3))
        )
        if is_shared and not self._shares:
            skills = []
        can = {name: self._capability(name) for name in skills}
        if component.name in {'a1', 'b2'} and (component.name == 'a1' or self._chance(0.2)):
            can['put'] = Capability('put', 'TASK_A', options={'qty_change': 1})
        if component.name == f'a{self.size}' or (
            component.name == f'b{self.size}' and self._chance(0.3)
        ):
            can['take'] = Capability('take', 'TASK_B', options={'qty_change': -1})
        return replace(
            component,
            durations_s={task: self._random.choice(SECONDS) for task in TASKS},
            capabilities=can,
            workspaces=self._spaces(component) if is_shared or self._chance(0.4) else (),
            prepare=self._preparation(component.name) if self._chance(0.3) else None,
        )

    def _spaces(self, component: Component) -> tuple[str, ...]:
        """Draw workspaces; those of one section have names of their own unless they are shared."""
        names = self._random.sample(SPACES, self._random.randint(1, 2))
        if self._shares and self._chance(0.5):
            return tuple(names)
        return tuple(f'{name}_{"_".join(map(str, component.sections))}' for name in names)

    def _preparation(self, name: str) -> Preparation:
        after = ('conveyor',) if self._chance(0.5) else ()
        return Preparation(f'prepare_{name}', 'PREPARE', after)

    def _capability(self, name: str) -> Capability:
        options: dict[str, Any] = {'requires_conveyor': False} if name in self._free else {}
        return Capability(
            name,
            self._random.choice(TASKS),
            parameters={'text': 'special_argument_1'},
            gives={'size': 'measurement', 'ok': 'item_present'} if name in self._given else {},
            needs={'size': 'special_argument_2'} if name == self._needing else {},
            holds={'pose': self._random.randint(1, 2)} if name in self._held else {},
            options=options,
        )

    # --- the recipe -------------------------------------------------------------------------

    def _recipe(self) -> Recipe:
        names = [f'o{number}' for number in range(self._count)]
        names.insert(self._random.choice((0, 0, 1, 2)) if len(names) > 1 else 0, 'put')
        names.append('take')
        written: list[Operation] = []
        for name in names:
            written.append(self._operation(name, written))
        again = self._again(written)
        return Recipe('drawn', 1, 'drawn', tuple(written), reworks=again)

    def _again(self, written: list[Operation]) -> tuple[Rework, ...]:
        """Draw a repeat of two operations, the second of which says whether it was well."""
        pairs = [
            number
            for number, (first, second) in enumerate(pairwise(written))
            if {'put', 'take'}.isdisjoint({first.id, second.id}) and {*second.do} <= self._given
        ]
        if not pairs or not self._chance(0.5):
            return ()
        number = self._random.choice(pairs)
        first, second = written[number : number + 2]
        size = Template((Reference('results', second.id, ('size',)),))
        options = {'fails_unless': Condition(size, at_least=-1.0)}
        written[number + 1] = replace(second, after=(first.id,), options=options)
        return (Rework((first.id, second.id), 1),)

    def _operation(self, name: str, written: list[Operation]) -> Operation:
        earlier = [op.id for op in written]
        after = tuple(earlier[-1:])
        if earlier and self._chance(0.4) and name != 'take':
            after = tuple(self._random.sample(earlier, min(len(earlier), 2)))
        if name in {'put', 'take'}:
            return Operation(name, (name,), after)
        many = min(len(self._skills), 2 if self._chance(0.2) else 1)
        do = tuple(self._random.sample(self._skills, many))
        givers = [
            op.id
            for op in written
            if {*op.do} <= self._given and 'put' not in op.do and not op.options
        ]
        needs: dict[str, str] = {}
        if self._needing in do and not givers:
            do = (self._skills[0],)
        elif self._needing in do:
            needs['size'] = self._random.choice(givers)
        keepers = [op.id for op in written if {*op.do} <= self._held]
        if keepers and self._chance(0.5):
            needs['pose'] = self._random.choice(keepers)
        return Operation(name, do, after, needs=needs, options=self._options(givers))

    def _options(self, givers: list[str]) -> Mapping[str, Any]:
        draw = self._random.random()
        if draw < 0.1:
            return {'on_failure': OnFailure.REJECT}
        if draw < 0.2:
            return {'on_failure': OnFailure.CONTINUE}
        if draw < 0.3 and givers:
            value = Template((Reference('results', self._random.choice(givers), ('ok',)),))
            return {'condition': Condition(value)}
        if draw < 0.33:
            return {'runs_for': RunsFor.REJECTED}
        return {}

    def _overrides(self) -> Overrides:
        if not self._chance(0.15):
            return Overrides()
        operation = self._random.choice(self.recipe.operations)
        able = [
            name
            for name, component in self.cell.components.items()
            if not {*operation.do}.isdisjoint(component.capabilities)
        ]
        return Overrides(bind={operation.id: self._random.choice(able)} if able else {})
