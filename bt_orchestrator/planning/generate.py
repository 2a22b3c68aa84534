"""From a recipe and a cell to a script, or to the reason why there is none."""

from __future__ import annotations

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.recipe import Overrides, Recipe
from bt_orchestrator.model.script import Script
from bt_orchestrator.planning.line_model import LineModel
from bt_orchestrator.planning.outcome import (
    LIMITS,
    SAME_S,
    Claim,
    Generated,
    Impossible,
    Judge,
    Limits,
)
from bt_orchestrator.planning.planner import Planner
from bt_orchestrator.planning.problem import Problem
from bt_orchestrator.planning.reasons import Reasons
from bt_orchestrator.planning.scripts import chosen

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
        raise Impossible([_not_kept(problem)])
    plan = best.solution.plan
    moved = tuple(
        name for name, one in chosen(plan, problem.plans).items() if problem.is_moved(one)
    )
    is_known = keep is None and best.bound_s <= best.per_item_s + SAME_S
    claim = Claim(
        best.pace,
        best.judged_s,
        bound_s=best.bound_s if is_known else None,
        spread_s=best.solution.spread_us / 1_000_000,
        moved=moved,
    )
    us = round(best.per_item_s * 1_000_000)
    reasons = Reasons(problem, LineModel(problem.plans), limits.nodes // 10)
    return Generated(best.script, reasons.made(best.solution, us, best.script), claim)


def _not_kept(problem: Problem) -> str:
    givers = ', '.join(f'`{one.giver}`' for one in problem.plans.reach.held)
    return (
        f'no device could keep what each of {givers} gives: one keeps it for one operation, '
        'for so many sections as it has room, and not in a repeat'
    )
