"""From a recipe and a cell to a script, or to the reason why there is none."""

from __future__ import annotations

from dataclasses import dataclass

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.recipe import Overrides, Recipe
from bt_orchestrator.model.script import Script
from bt_orchestrator.planning.line_model import LineModel, Solution
from bt_orchestrator.planning.outcome import (
    LIMITS,
    SAME_S,
    Claim,
    Generated,
    Impossible,
    Judge,
    Limits,
    NotFound,
)
from bt_orchestrator.planning.problem import Problem
from bt_orchestrator.planning.reasons import Reasons
from bt_orchestrator.planning.scripts import chosen
from bt_orchestrator.proof.pace import Pace, pace

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
    return _Generator(problem, judge, limits).run()


@dataclass(frozen=True)
class _Judged:
    """A plan as a script, with the time that it takes."""

    solution: Solution
    script: Script
    pace: Pace
    judged_s: float | None

    @property
    def per_item_s(self) -> float:
        return self.pace.per_item_s if self.judged_s is None else self.judged_s


class _Generator:
    def __init__(self, problem: Problem, judge: Judge, limits: Limits) -> None:
        self._problem, self._judge, self._limits = problem, judge, limits
        self._model = LineModel(problem.plans)

    def run(self) -> Generated:
        first = self._model.best(self._limits.nodes)
        if first is None:
            raise Impossible([self._not_kept()])
        best = self._best(first)
        if best is None:
            raise NotFound([f'the engine gets to the end with none of the best plans; {_BIND}'])
        bound_s = first.bound_us / 1_000_000
        is_known = self._problem.keep is None and bound_s <= best.per_item_s + SAME_S
        problem, plan = self._problem, best.solution.plan
        moved = tuple(
            name for name, one in chosen(plan, problem.plans).items() if problem.is_moved(one)
        )
        claim = Claim(best.pace, best.judged_s, bound_s if is_known else None, moved)
        us = round(best.per_item_s * 1_000_000)
        reasons = Reasons(problem, LineModel(problem.plans), self._limits.nodes)
        facts = reasons.made(best.solution, us, best.script)
        return Generated(best.script, facts, claim)

    def _best(self, solution: Solution | None) -> _Judged | None:
        """Return the best of the next plans: what the model says of them is only a bound."""
        best: _Judged | None = None
        moved = solution.moved if solution is not None else 0
        for _ in range(self._limits.finalists):
            if solution is None or solution.moved > moved:
                break
            if best is not None and best.per_item_s <= solution.bound_us / 1_000_000 + SAME_S:
                break  # the others are no better
            judged = self._judged(solution)
            if judged is not None and (
                best is None or judged.per_item_s < best.per_item_s - SAME_S
            ):
                best = judged
            self._model.exclude(solution.plan)
            solution = self._next()
        return best

    def _next(self) -> Solution | None:
        try:
            return self._model.best(self._limits.nodes)
        except NotFound:
            return None

    def _judged(self, solution: Solution) -> _Judged | None:
        """Compute the pace of a plan anew; None: it gets stuck."""
        script = self._problem.script(solution.plan)
        found = pace(script, self._problem.cell)
        if found is None:
            return None
        if not (found.not_counted and self._problem.plans.shared):
            return _Judged(solution, script, found, None)
        judged_s = self._judge.pace_s(script)
        return None if judged_s is None else _Judged(solution, script, found, judged_s)

    def _not_kept(self) -> str:
        givers = ', '.join(f'`{one.giver}`' for one in self._problem.plans.reach.held)
        return (
            f'no device could keep what each of {givers} gives: one keeps it for one operation, '
            'for so many sections as it has room, and not in a repeat'
        )


_BIND = '`bind` operations that share a zone or a component otherwise, in the overrides'
