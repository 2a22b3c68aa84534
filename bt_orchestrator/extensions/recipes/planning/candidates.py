"""Candidates: which component can do an operation, with which capability, in which section."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from bt_orchestrator.model.cell import Capability, Cell, Component, OnFailure
from bt_orchestrator.model.condition import Condition
from bt_orchestrator.model.recipe import Operation, Overrides, Recipe
from bt_orchestrator.model.reference import Reference, references
from bt_orchestrator.model.script import RunsFor


@dataclass(frozen=True, eq=False)
class Candidate:
    """One way to do one operation."""

    operation: Operation
    component: Component
    capability: Capability
    section: int
    options: Mapping[str, Any]
    """Fields of the task: of the capability, the operation and its overrides; the last counts."""
    us: int
    """Microseconds that it takes with a good item."""

    @property
    def needs_belt(self) -> bool:
        """Tell whether the belt has to rest."""
        return bool(self.options.get('requires_conveyor', True))

    @property
    def may_reject(self) -> bool:
        """Tell whether the item may be rejected by it."""
        return self.options.get('on_failure') is OnFailure.REJECT

    @property
    def qty_change(self) -> int:
        """Its change on the belt."""
        return int(self.options.get('qty_change', 0))

    @property
    def runs_for(self) -> RunsFor:
        """The items that it runs for."""
        items: RunsFor = self.options.get('runs_for', RunsFor.GOOD)
        return items

    @cached_property
    def spaces(self) -> frozenset[str]:
        """The things for it alone at a time: its workspaces, and the component itself."""
        spaces = {f'workspace {name}' for name in self.component.workspaces}
        return frozenset(spaces | {self.component.name})


@dataclass
class Candidates:
    """All candidates, by operation; in the order of preference."""

    of: dict[str, list[Candidate]] = field(default_factory=dict)
    reasons: list[str] = field(default_factory=list)
    """Why operations have none."""


def candidates(
    cell: Cell, recipe: Recipe, overrides: Overrides, without: frozenset[str]
) -> Candidates:
    """Find who can do what.

    :param without: components that are out of service
    """
    result = Candidates()
    wanted = wanted_of(recipe, overrides)
    for operation in recipe.operations:
        ways = _Ways(cell, operation, overrides, wanted[operation.id])
        able = list(ways.find())
        serving = [candidate for candidate in able if candidate.component.name not in without]
        result.of[operation.id] = serving
        if not serving:
            result.reasons.append(_why_none(operation.id, able, ways))
    return result


def wanted_of(recipe: Recipe, overrides: Overrides) -> Mapping[str, frozenset[str]]:
    """Return the things that each operation has to give, by its id."""
    wanted: dict[str, set[str]] = defaultdict(set)
    for operation in recipe.operations:
        for name, giver in operation.needs.items():
            wanted[giver].add(name)
        for giver, names in named_results(operation, overrides):
            wanted[giver].update(names[:1])
    return {operation.id: frozenset(wanted[operation.id]) for operation in recipe.operations}


def named_results(
    operation: Operation, overrides: Overrides
) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Yield the results that the values of an operation name: whose, and the path in it."""
    options = {**operation.options, **overrides.options.get(operation.id, {})}
    conditions = [option for option in options.values() if isinstance(option, Condition)]
    named = [*references(operation.parameters)]
    named += [reference for condition in conditions for reference in condition.references]
    if 'identifies' in options:
        named.append(Reference('results', operation.id, options['identifies']))
    for mention in named:
        if mention.source == 'results':
            yield mention.name, mention.fields


class _Ways:
    """The candidates of one operation, and why others are none."""

    def __init__(
        self, cell: Cell, operation: Operation, overrides: Overrides, wanted: frozenset[str]
    ) -> None:
        self._cell = cell
        self._operation = operation
        self._more = {**operation.options, **overrides.options.get(operation.id, {})}
        self._wanted = wanted
        self.bound = overrides.bind.get(operation.id)
        self.unfit: list[str] = []

    def find(self) -> Iterator[Candidate]:
        """Yield them; of equals the first capability, then the first component of the cell."""
        names = [name for name in self._cell.components if self.bound in (None, name)]
        for capability in self._operation.do:
            for component in (self._cell.components[name] for name in names):
                can = component.capabilities.get(capability)
                if can is not None and self._fits(component, can):
                    yield from self._in_sections(component, can)
        if self.bound is not None and not self._can(self.bound):
            can_not = ' or '.join(f'`{capability}`' for capability in self._operation.do)
            self.unfit.append(f'it is bound to {self.bound}, which does not have {can_not}')

    def _can(self, name: str) -> bool:
        component = self._cell.components.get(name)
        return component is not None and any(
            capability in component.capabilities for capability in self._operation.do
        )

    def _fits(self, component: Component, can: Capability) -> bool:
        """Tell whether the recipe gives it what it needs, and wants of it what it gives."""
        who = f'`{can.name}` of {component.name}'
        faults = [
            *(
                f'{who} needs `{thing}`, and no operation gives it'
                for thing in can.needs
                if thing not in self._operation.needs
            ),
            *(
                f'{who} does not give `{thing}`'
                for thing in sorted(self._wanted)
                if thing not in can.gives and thing not in can.holds
            ),
        ]
        self.unfit += faults
        return not faults

    def _in_sections(self, component: Component, can: Capability) -> Iterator[Candidate]:
        options = {**can.options, **self._more}
        runs_for = options.get('runs_for', RunsFor.GOOD)
        us = round(component.duration_s(can.task) * 1_000_000)
        if not runs_for.includes(rejected=False):
            us = 0
        everywhere = range(1, self._cell.conveyor.sections + 1)
        for section in component.sections or everywhere:
            yield Candidate(self._operation, component, can, section, options, us)


def _why_none(operation: str, able: list[Candidate], ways: _Ways) -> str:
    if able:
        names = list(dict.fromkeys(candidate.component.name for candidate in able))
        are = 'it is' if len(names) == 1 else 'they are'
        return f'`{operation}`: only {" or ".join(names)} could, and {are} out of service'
    why = '; '.join(dict.fromkeys(ways.unfit))
    return f'`{operation}`: no component can do it' + (f': {why}' if why else '')
