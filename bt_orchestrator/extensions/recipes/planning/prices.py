"""The price of doing an operation with another component: it is fixed there, and solved again."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from bt_orchestrator.extensions.recipes.planning.candidates import candidates
from bt_orchestrator.extensions.recipes.planning.line_model import LineModel
from bt_orchestrator.extensions.recipes.planning.outcome import (
    LIMITS,
    SAME_S,
    Generated,
    Impossible,
    Judge,
    Limits,
    NotMade,
    Price,
)
from bt_orchestrator.extensions.recipes.planning.planner import Best, Planner
from bt_orchestrator.extensions.recipes.planning.problem import Problem


def prices(
    problem: Problem, made: Generated, judge: Judge, limits: Limits = LIMITS
) -> Mapping[str, tuple[Price, ...]]:
    """Return the price of each other component of each operation, by operation.

    An operation that an override binds has none.
    """
    able = candidates(problem.cell, problem.recipe, problem.overrides, problem.without)
    prices = _Prices(problem, made, Planner(problem, judge, limits))
    return {
        name: tuple(
            prices.of(name, other)
            for other in dict.fromkeys(one.component.name for one in ways)
            if other != made.made[name].component
        )
        for name, ways in able.of.items()
    }


class _Prices:
    def __init__(self, problem: Problem, made: Generated, planner: Planner) -> None:
        self._problem, self._claim, self._planner = problem, made.claim, planner

    def of(self, operation: str, component: str) -> Price:
        """Fix an operation at a component, and solve again."""
        model = LineModel(self._problem.plans)
        model.bind(operation, component)
        try:
            best = self._planner.best(model)
            if best is None:
                raise Impossible(self._why_not(operation, component))
        except NotMade as fault:
            is_impossible = isinstance(fault, Impossible)
            return Price(component, reasons=fault.reasons, is_impossible=is_impossible)
        return self._price(component, best)

    def _price(self, component: str, best: Best) -> Price:
        own, claim = self._claim, best.claim
        bound_s = claim.bound_s or 0.0
        is_exact = claim.judged_s is None and bound_s >= claim.per_item_s - SAME_S
        return Price(
            component,
            more_s=claim.per_item_s - own.per_item_s,
            at_least_s=bound_s - own.per_item_s,
            spread_s=claim.spread_s - own.spread_s,
            is_least=is_exact and best.solution.is_spread_least,
        )

    def _why_not(self, operation: str, component: str) -> tuple[str, ...]:
        bind = {**self._problem.overrides.bind, operation: component}
        overrides = replace(self._problem.overrides, bind=bind)
        try:
            _ = replace(self._problem, overrides=overrides).plans
        except Impossible as why:
            return why.reasons
        return ('no device could keep what others need then',)
