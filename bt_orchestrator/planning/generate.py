"""From a recipe and a cell to a script, or to the reason why there is none."""

from __future__ import annotations

from fractions import Fraction

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.recipe import Overrides, Recipe
from bt_orchestrator.model.script import Script
from bt_orchestrator.planning.bound import Bound
from bt_orchestrator.planning.outcome import (
    LIMITS,
    Claim,
    Generated,
    Impossible,
    Judge,
    Limits,
    NotFound,
)
from bt_orchestrator.planning.plans import Plan
from bt_orchestrator.planning.problem import Problem
from bt_orchestrator.planning.reasons import made
from bt_orchestrator.planning.scripts import chosen
from bt_orchestrator.planning.search import Search
from bt_orchestrator.planning.starts import starts
from bt_orchestrator.planning.windows import Windows
from bt_orchestrator.proof.pace import pace

NO_OVERRIDES = Overrides()

_FOR_EVER_US = 10**18

_SAME_S = 1e-6
"""Runs of the engine that differ by less are equally fast."""


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


class _Generator:
    def __init__(self, problem: Problem, judge: Judge, limits: Limits) -> None:
        self._problem, self._judge, self._limits = problem, judge, limits

    def run(self) -> Generated:
        plans = self._problem.plans
        search = Search(plans)
        search.run(starts(plans), self._limits.kicks)
        if search.best is None:
            search.run([self._any()], self._limits.kicks)
        if search.best is None:
            raise NotFound([_not_found(self._limits)])
        cost, plan = search.best
        if plans.shares:
            return self._judged(cost.moved)
        if self._problem.keep is not None:
            return self._generated(plan)
        is_fastest = self._proven(search)
        if not is_fastest and not plans.has_flags:
            limits = self._limits
            plan = Windows(plans).better(search.best[1], limits.windows, limits.window_nodes)
            search.run([plan], 0)
            is_fastest = self._proven(search)
        return self._generated(search.best[1], is_fastest=is_fastest)

    def _proven(self, search: Search) -> bool:
        """Prove that no binding is faster than the best one, or go on from a faster one."""
        assert search.best is not None
        bound = Bound(self._problem.plans, self._limits.nodes)
        bound.look(search.best[0].us)
        if bound.faster is not None:
            search.run([bound.faster], 0)  # of equally fast ones the one that spreads best
        return bound.is_proven

    def _any(self) -> Plan:
        """Return any plan, because the search has found none: devices keep too little.

        :raises Impossible: it is proven that there is none
        :raises NotFound: there was none among those that were tried
        """
        bound = Bound(self._problem.plans, self._limits.nodes)
        bound.look(_FOR_EVER_US)
        if bound.faster is not None:
            return bound.faster
        givers = ', '.join(f'`{one.giver}`' for one in self._problem.plans.reach.held)
        why = (
            f'no device could keep what each of {givers} gives: one keeps it for one operation, '
            'for so many sections as it has room, and not in a repeat'
        )
        if bound.is_proven:
            raise Impossible([why])
        raise NotFound([f'{_not_found(self._limits)}; of those that were tried, {why}; {_NEARER}'])

    def _judged(self, moved: int) -> Generated:
        """Return the best of the finalists by the engine.

        :param moved: operations that have to be elsewhere than in the script that is kept
        """
        plans, best = self._problem.plans, None
        for cost, plan in plans.best(self._limits.finalists):
            at_best_s = float(cost.us / 1_000_000)
            if cost.moved > moved or (best is not None and best[0] <= at_best_s):
                break  # the others are no better
            script = self._problem.script(plan)
            found = pace(script, self._problem.cell)
            waits = found is not None and found.not_counted
            judged_s = self._judge.pace_s(script) if waits else at_best_s
            if judged_s is not None and (best is None or judged_s < best[0] - _SAME_S):
                best = judged_s, plan
        if best is None:
            raise NotFound(
                [f'the engine gets to the end with none of the best plans; {_OTHERWISE}']
            )
        judged_s, plan = best
        if self._problem.keep is not None:
            return self._generated(plan, judged_s=judged_s)
        bound = Bound(plans, self._limits.nodes)
        bound.look(Fraction(round(judged_s * 1_000_000)))
        is_fastest = bound.is_proven and bound.faster is None
        return self._generated(plan, judged_s=judged_s, is_fastest=is_fastest)

    def _generated(
        self, plan: Plan, *, judged_s: float | None = None, is_fastest: bool = False
    ) -> Generated:
        problem = self._problem
        script = problem.script(plan)
        found = pace(script, problem.cell)
        assert found is not None, 'a plan that gets stuck has no cost'
        moved = tuple(
            name for name, one in chosen(plan, problem.plans).items() if problem.is_moved(one)
        )
        claim = Claim(found, judged_s if found.not_counted else None, is_fastest, moved)
        return Generated(script, made(plan, problem.plans, problem.overrides, script), claim)


_NEARER = '`bind` what needs it nearer to it, in the overrides'
_OTHERWISE = '`bind` operations that share a zone or a component otherwise, in the overrides'


def _not_found(limits: Limits) -> str:
    return f'not found within {limits.nodes:,} steps; not proven impossible'
