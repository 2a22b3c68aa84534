"""From a recipe and a cell to a script, or to the reason why there is none."""

from __future__ import annotations

from contextlib import suppress
from copy import copy
from dataclasses import replace

from bt_orchestrator.extensions.recipes.planning.line_model import LineModel
from bt_orchestrator.extensions.recipes.planning.order import quoted
from bt_orchestrator.extensions.recipes.planning.outcome import (
    LIMITS,
    SAME_S,
    Generated,
    Impossible,
    Judge,
    Limits,
    NotFound,
)
from bt_orchestrator.extensions.recipes.planning.planner import Planner
from bt_orchestrator.extensions.recipes.planning.problem import Problem
from bt_orchestrator.extensions.recipes.planning.reasons import Reasons
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.recipe import Overrides, Recipe
from bt_orchestrator.model.script import Script

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
    problem = Problem(cell, recipe, overrides, without, keep)
    best = Planner(problem, judge, limits).best(LineModel(problem.plans))
    if best is None:
        raise Impossible([_not_kept(problem, limits.nodes)])
    claim = best.claim
    if keep is not None or (claim.bound_s or 0.0) > claim.per_item_s + SAME_S:
        claim = replace(claim, bound_s=None)
    us = round(claim.per_item_s * 1_000_000)
    reasons = Reasons(problem, LineModel(problem.plans), limits.nodes // 10)
    return Generated(best.script, reasons.made(best.solution, us, best.script), claim)


def _not_kept(problem: Problem, nodes: int) -> str:
    """Say what devices cannot keep together; without any one of it there would be a plan."""
    plans = copy(problem.plans)
    needed = plans.held
    for one in plans.held:
        plans.held = tuple(other for other in needed if other is not one)
        with suppress(NotFound):
            if LineModel(plans).best(nodes) is None:
                needed = plans.held
    told = ', and '.join(
        f'`{one.name}` of `{one.giver}` for {quoted(one.takers)}' for one in needed
    )
    return (
        f'no device can keep {told}: one keeps it for one operation, for so many sections as it '
        'has room, and not in a repeat'
    )
