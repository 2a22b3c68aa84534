"""From a recipe and a cell to a script, or to the reason why there is none."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from copy import copy
from dataclasses import replace

from bt_orchestrator.extensions.recipes.planning.candidates import Candidate
from bt_orchestrator.extensions.recipes.planning.line_model import LineModel, Solution
from bt_orchestrator.extensions.recipes.planning.order import quoted
from bt_orchestrator.extensions.recipes.planning.outcome import (
    LIMITS,
    SAME_S,
    Generated,
    Impossible,
    Judge,
    Limits,
    Made,
    NotFound,
    Why,
)
from bt_orchestrator.extensions.recipes.planning.planner import Planner, Problem
from bt_orchestrator.extensions.recipes.planning.scripts import chosen
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
    for held in plans.held:
        plans.held = tuple(other for other in needed if other is not held)
        with suppress(NotFound):
            if LineModel(plans).best(nodes) is None:
                needed = plans.held
    things = ', and '.join(
        f'`{held.name}` of `{held.giver}` for {quoted(held.takers)}' for held in needed
    )
    return (
        f'no device can keep {things}: one keeps it for one operation, for so many sections as it '
        'has room, and not in a repeat'
    )


# Why each component does what it does; what is said is proven by the model.


class Reasons:
    """The reasons of one script."""

    def __init__(self, problem: Problem, model: LineModel, nodes: int) -> None:
        self._problem, self._model, self._nodes = problem, model, nodes

    def made(self, solution: Solution, us: int, script: Script) -> dict[str, Made]:
        """Return where each task came from, in the order of the script.

        :param us: microseconds that the script takes for each item
        """
        plans, bind = self._problem.plans, self._problem.overrides.bind
        candidates = chosen(solution.plan, plans)
        others = {name: self._others(candidate) for name, candidate in candidates.items()}
        whys = {name: Why.OVERRIDE if name in bind else Why.ONLY for name in candidates}
        asked = {
            name: candidate
            for name, candidate in candidates.items()
            if others[name] and name not in bind
        }
        whys.update(self._whys(asked, solution, us))
        facts = {
            task.id: Made(task.id, '', task.component, 0, Why.ONLY)
            for task in script.initialization
        }
        for task in (task for section in script.sections.values() for task in section.tasks):
            candidate = candidates[task.id]
            facts[task.id] = Made(
                operation=task.id,
                capability=candidate.capability.name,
                component=candidate.component.name,
                section=candidate.section,
                why=whys[task.id],
                alternatives=others[task.id],
            )
        return facts

    def _others(self, candidate: Candidate) -> tuple[str, ...]:
        plans, name = self._problem.plans, candidate.operation.id
        ways = plans.choices[plans.pieces.number_of[name]]
        members = (member for choice in ways for member in choice.members)
        same = [member.component.name for member in members if member.operation.id == name]
        return tuple(other for other in dict.fromkeys(same) if other != candidate.component.name)

    def _whys(
        self, asked: Mapping[str, Candidate], solution: Solution, us: int
    ) -> Mapping[str, Why]:
        if not asked:
            return {}
        if self._problem.keep is not None:
            moved = {
                name for name, candidate in asked.items() if self._problem.is_moved(candidate)
            }
            return {name: Why.FOUND if name in moved else Why.KEPT for name in asked}
        fast, is_proven = self._model.elsewhere(asked, self._nodes, us=us)
        slower = Why.PACE if is_proven else Why.FOUND
        whys = {name: slower for name in asked if name not in fast}
        if not fast:
            return whys
        asked = {name: candidate for name, candidate in asked.items() if name in fast}
        good, is_proven = self._model.elsewhere(
            asked, self._nodes, us=us, spread_us=solution.spread_us
        )
        worse = Why.SPREAD if is_proven else Why.FOUND
        equal = Why.EQUAL if self._model.is_exact else Why.FOUND
        for name in asked:
            whys[name] = equal if name in good else worse
        return whys
