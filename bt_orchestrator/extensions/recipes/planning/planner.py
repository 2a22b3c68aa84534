"""The best plan of a model, recomputed by rule 8.4 or run by the engine; prices of others."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

from bt_orchestrator.extensions.recipes.planning.candidates import Candidate, candidates
from bt_orchestrator.extensions.recipes.planning.line_model import LineModel, Solution
from bt_orchestrator.extensions.recipes.planning.order import Order, ends
from bt_orchestrator.extensions.recipes.planning.outcome import (
    LIMITS,
    SAME_S,
    Claim,
    Generated,
    Impossible,
    Judge,
    Limits,
    NotFound,
    NotMade,
    Price,
)
from bt_orchestrator.extensions.recipes.planning.pieces import Pieces
from bt_orchestrator.extensions.recipes.planning.reach import Held, Reach
from bt_orchestrator.extensions.recipes.planning.scripts import Plan, Plans, PlanWriter
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.proof.pace import pace
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

    def is_moved(self, candidate: Candidate) -> bool:
        """Tell whether an operation would be done elsewhere than in the script that is kept."""
        if self.keep is None:
            return False
        before = self.keep.tasks.get(candidate.operation.id)
        return (
            before is None
            or before.component != candidate.component.name
            or self.keep.section_of(before.id) != candidate.section
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
                rival = self._judged(solution, bound_s)
                is_better = best is None or (
                    rival and rival.claim.per_item_s < best.claim.per_item_s - SAME_S
                )
                best = rival if is_better else best
            if best is not None and own_s >= best.claim.per_item_s - SAME_S:
                break  # the others are no better
        if best is None and bound_s is not None:
            raise NotFound([f'no plan among the best reaches the end in the engine; {_BIND}'])
        return best

    def _solutions(self, model: LineModel) -> Iterator[Solution]:
        """Yield the best plan, and the next ones, each without those before."""
        first = solution = model.best(self._limits.nodes, self._limits.question_nodes)
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
        line_pace = pace(script, self._problem.cell)
        if line_pace is None:
            return None
        claim = Claim(line_pace, None, bound_s, solution.spread_us / 1_000_000)
        if line_pace.not_counted and self._problem.plans.shared:
            judged_s = self._judge.pace_s(script)
            if judged_s is None:
                return None
            claim = replace(claim, judged_s=judged_s)
        return Best(solution, script, claim)


# The price of doing an operation with another component: it is fixed there, and solved again.


def prices(
    problem: Problem, made: Generated, judge: Judge, limits: Limits = LIMITS
) -> Mapping[str, tuple[Price, ...]]:
    """Return the price of each other component of each operation, by operation.

    An operation that an override binds has none.
    """
    able = candidates(problem.cell, problem.recipe, problem.overrides, problem.without)
    # A price may be a bound, and there are many of them.
    planner = Planner(problem, judge, replace(limits, question_nodes=0))
    prices = _Prices(problem, made, planner)
    return {
        name: tuple(
            prices.of(name, other)
            for other in dict.fromkeys(way.component.name for way in ways)
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
