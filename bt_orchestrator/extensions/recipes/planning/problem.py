"""The problem: a recipe, a cell, and what an engineer has decided; all plans for it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property

from bt_orchestrator.extensions.recipes.planning.candidates import Candidate, candidates
from bt_orchestrator.extensions.recipes.planning.order import Order, ends
from bt_orchestrator.extensions.recipes.planning.outcome import Impossible
from bt_orchestrator.extensions.recipes.planning.pieces import Pieces
from bt_orchestrator.extensions.recipes.planning.reach import Held, Reach
from bt_orchestrator.extensions.recipes.planning.scripts import Plan, Plans, PlanWriter
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.recipe import Overrides, Recipe
from bt_orchestrator.model.script import Script


@dataclass(frozen=True)
class Problem:
    """The product to make, and the equipment for it."""

    cell: Cell
    recipe: Recipe
    overrides: Overrides = field(default_factory=Overrides)
    without: frozenset[str] = frozenset()
    """Components that are out of service."""
    keep: Script | None = None
    """As little as possible is done elsewhere than in it."""

    @cached_property
    def plans(self) -> Plans:
        """All plans that are within reach.

        :raises Impossible: there are none
        """
        belt = self.cell.conveyor
        return Plans(
            self._reach(),
            round(belt.component.duration_s(belt.task) * 1_000_000),
            moved=lambda choice: sum(map(self.is_moved, choice.members)),
        )

    def script(self, plan: Plan) -> Script:
        """Write a plan down."""
        return PlanWriter(plan, self.plans, self.cell, self.recipe, self.without).script()

    def is_moved(self, one: Candidate) -> bool:
        """Tell whether an operation would be done elsewhere than in the script that is kept."""
        if self.keep is None:
            return False
        before = self.keep.tasks.get(one.operation.id)
        return (
            before is None
            or before.component != one.component.name
            or self.keep.section_of(before.id) != one.section
        )

    def _reach(self) -> Reach:
        able = candidates(self.cell, self.recipe, self.overrides, self.without)
        reasons = able.reasons
        if self.cell.conveyor.component.name in self.without:
            reasons = ['the conveyor is out of service, and nothing moves without it', *reasons]
        _need_none(reasons)
        line, faults = ends(able.of)
        if line is None:
            raise Impossible(faults)
        order = Order(self.recipe, self.overrides, able.of, line)
        pieces = Pieces(self.recipe, order, able.of)
        if pieces.circle:
            circle = ', '.join(pieces.circle)
            raise Impossible(
                [f'operations wait for each other: {circle}; remove one of the waits']
            )
        _need_none([*order.faults])
        reach = Reach(pieces, line, tuple(_held(self.recipe)))
        _need_none([reach.reason] if reach.reason else [])
        return reach


def _need_none(reasons: list[str]) -> None:
    if reasons:
        raise Impossible(reasons)


def _held(recipe: Recipe) -> Iterator[Held]:
    """Yield what operations need of others."""
    needed: dict[tuple[str, str], list[str]] = {}
    for operation in recipe.operations:
        for name, giver in operation.needs.items():
            needed.setdefault((name, giver), []).append(operation.id)
    for (name, giver), takers in needed.items():
        yield Held(name, giver, tuple(takers))
