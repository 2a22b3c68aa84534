"""The best plan of a model, recomputed by rule 8.4 or run by the engine."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from bt_orchestrator.extensions.recipes.planning.line_model import LineModel, Solution
from bt_orchestrator.extensions.recipes.planning.outcome import (
    SAME_S,
    Claim,
    Judge,
    Limits,
    NotFound,
)
from bt_orchestrator.extensions.recipes.planning.problem import Problem
from bt_orchestrator.model.proof.pace import pace
from bt_orchestrator.model.script import Script

_BIND = '`bind` operations that share a zone or a component otherwise, in the overrides'


@dataclass(frozen=True)
class Best:
    """A plan as a script, with the time that it takes."""

    solution: Solution
    script: Script
    claim: Claim


class Planner:
    """Solves models of one problem."""

    def __init__(self, problem: Problem, judge: Judge, limits: Limits) -> None:
        self._problem, self._judge, self._limits = problem, judge, limits

    def best(self, model: LineModel) -> Best | None:
        """Return the best plan of a model; None: it has none.

        What the model says of a plan may be only a bound, so the next plans are computed as well.

        :raises NotFound: none was found
        """
        best: Best | None = None
        bound_s: float | None = None
        for solution in self._solutions(model):
            own_s = solution.us / 1_000_000
            bound_s = solution.bound_us / 1_000_000 if bound_s is None else bound_s
            if best is None or own_s < best.claim.per_item_s - SAME_S:
                found = self._judged(solution, bound_s)
                is_better = best is None or (
                    found and found.claim.per_item_s < best.claim.per_item_s - SAME_S
                )
                best = found if is_better else best
            if best is not None and own_s >= best.claim.per_item_s - SAME_S:
                break  # the others are no better
        if best is None and bound_s is not None:
            raise NotFound([f'no plan among the best reaches the end in the engine; {_BIND}'])
        return best

    def _solutions(self, model: LineModel) -> Iterator[Solution]:
        """Yield the best plan, and the next ones, each without those before."""
        first = solution = model.best(self._limits.nodes)
        for _ in range(self._limits.finalists):
            if first is None or solution is None or solution.moved > first.moved:
                return
            yield solution
            model.exclude(solution.plan)
            try:
                solution = model.best(self._limits.nodes)
            except NotFound:
                return

    def _judged(self, solution: Solution, bound_s: float) -> Best | None:
        """Compute the pace of a plan anew; None: it gets stuck."""
        script = self._problem.script(solution.plan)
        found = pace(script, self._problem.cell)
        if found is None:
            return None
        claim = Claim(found, None, bound_s, solution.spread_us / 1_000_000)
        if found.not_counted and self._problem.plans.shared:
            judged_s = self._judge.pace_s(script)
            if judged_s is None:
                return None
            claim = replace(claim, judged_s=judged_s)
        return Best(solution, script, claim)
