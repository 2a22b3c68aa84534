"""From a recipe and a cell to a script, or to the reason why there is none."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.recipe import Overrides, Recipe
from bt_orchestrator.model.script import Script
from bt_orchestrator.planning.candidates import candidates
from bt_orchestrator.planning.order import Order, ends
from bt_orchestrator.planning.outcome import (
    LIMITS,
    Claim,
    Generated,
    Impossible,
    Judge,
    Limits,
    NotFound,
)
from bt_orchestrator.planning.pieces import Choice, Pieces
from bt_orchestrator.planning.plans import Plan, Plans
from bt_orchestrator.planning.reach import Held, Reach
from bt_orchestrator.planning.reasons import made
from bt_orchestrator.planning.scripts import script_of
from bt_orchestrator.planning.search import Search
from bt_orchestrator.proof.pace import PacedLine, pace

NO_OVERRIDES = Overrides()


def generate(
    cell: Cell,
    recipe: Recipe,
    overrides: Overrides = NO_OVERRIDES,
    *,
    without: frozenset[str] = frozenset(),
    keep: Script | None = None,
    judge: Judge,
    limits: Limits = LIMITS,
) -> Generated:
    """Make the script of a recipe for a cell.

    :param without: components that are out of service
    :param keep: a script of before: as little as possible is done elsewhere than in it
    :param judge: the engine in virtual time; asked where sections share something
    :raises Impossible: it is proven that there is none
    :raises NotFound: none was found
    """
    return _Generator(cell, recipe, overrides, without, keep, judge, limits).run()


class _Generator:
    def __init__(
        self,
        cell: Cell,
        recipe: Recipe,
        overrides: Overrides,
        without: frozenset[str],
        keep: Script | None,
        judge: Judge,
        limits: Limits,
    ) -> None:
        self._cell, self._recipe, self._overrides = cell, recipe, overrides
        self._without, self._keep = without, keep
        self._judge, self._limits = judge, limits

    def run(self) -> Generated:
        plans = self._plans()
        found = Search(plans, self._limits).run(self._starts(plans))
        if not found:
            raise NotFound(['every plan that was tried gets stuck; that all do is not proven'])
        return self._generated(found[0], plans)

    def _plans(self) -> Plans:
        """Return the plans that are within reach.

        :raises Impossible: there are none
        """
        able = candidates(self._cell, self._recipe, self._overrides, self._without)
        if self._cell.conveyor.component.name in self._without:
            able.reasons.append('the conveyor is out of service, and nothing moves without it')
        if able.reasons:
            raise Impossible(able.reasons)
        line, faults = ends(able.of)
        if line is None:
            raise Impossible(faults)
        if self._recipe.reworks:
            raise NotFound(['operations that repeat are not generated yet'])
        order = Order(self._recipe, self._overrides, able.of, line)
        pieces = Pieces(self._recipe, order, able.of)
        if pieces.circle:
            raise Impossible([f'operations wait for each other: {", ".join(pieces.circle)}'])
        faults = list(order.faults)
        if faults:
            raise Impossible(faults)
        reach = Reach(pieces, line, tuple(_held(self._recipe)))
        if reach.reason:
            raise Impossible([reach.reason])
        flagged = any(one.capability.holds for ways in able.of.values() for one in ways) and bool(
            reach.held
        )
        move_us = round(
            self._cell.components[self._cell.conveyor.component.name].duration_s(
                self._cell.conveyor.task
            )
            * 1_000_000
        )
        plans = Plans(
            reach,
            move_us,
            is_kept=self._moved,
            closed_us=self._closed_us if flagged else None,
        )
        self._all = plans
        return plans

    def _starts(self, plans: Plans) -> Iterator[Plan]:
        yield plans.first()

    def _moved(self, choice: Choice) -> int:
        """Count the operations of a choice that were done elsewhere before."""
        if self._keep is None:
            return 0
        before = self._keep.tasks
        return sum(
            one.operation.id not in before
            or before[one.operation.id].component != one.component.name
            or self._keep.section_of(one.operation.id) != one.section
            for one in choice.members
        )

    def _script(self, plan: Plan, plans: Plans) -> Script:
        return script_of(plan, plans, self._cell, self._recipe, self._without)

    def _closed_us(self, plan: Plan) -> Fraction | None:
        line = PacedLine(self._script(plan, self._all), self._cell)
        return None if line.gets_stuck else line.limit(line.durations(self._cell)).per_item_us

    def _generated(self, plan: Plan, plans: Plans) -> Generated:
        script = self._script(plan, plans)
        found = pace(script, self._cell)
        if found is None:
            raise NotFound(['every plan that was tried gets stuck; that all do is not proven'])
        return Generated(script, made(plan, plans, self._overrides, script), Claim(found))


def _held(recipe: Recipe) -> Iterator[Held]:
    """Yield what operations need of others."""
    needed: dict[tuple[str, str], list[str]] = {}
    for operation in recipe.operations:
        for name, giver in operation.needs.items():
            needed.setdefault((name, giver), []).append(operation.id)
    for (name, giver), takers in needed.items():
        yield Held(name, giver, tuple(takers))
