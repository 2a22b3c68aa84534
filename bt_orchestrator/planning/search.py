"""The search for the best plan: from several starts downhill, then again from near the best.

Nothing in it depends on time, on the order of sets, or on hashes: equal inputs give equal plans.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from random import Random

from bt_orchestrator.planning.outcome import Limits
from bt_orchestrator.planning.plans import Cost, Plan, Plans


class Search:
    """A search over the plans of a recipe."""

    def __init__(self, plans: Plans, limits: Limits) -> None:
        self._plans = plans
        self._limits = limits
        self._seen: dict[Plan, Cost] = {}
        """Plans that were the best around them, or on the way there."""

    def run(self, starts: Iterable[Plan]) -> list[Plan]:
        """Return the best plans found, the best one first; none: all that was tried gets stuck."""
        for start in starts:
            self._downhill(start)
        random = Random(0)  # the same draws in every run
        for _ in range(self._limits.kicks):
            if not self._seen:
                break
            self._downhill(self._kicked(self._best(), random))
        return sorted(self._seen, key=lambda plan: (self._seen[plan], plan))

    def _best(self) -> Plan:
        return min(self._seen, key=lambda plan: (self._seen[plan], plan))

    def _kicked(self, plan: Plan, random: Random) -> Plan:
        """Return a plan with some choices drawn anew."""
        free = [piece for piece, ways in enumerate(self._plans.choices) if len(ways) > 1]
        for piece in random.sample(free, min(len(free), 3)):
            number = random.randrange(len(self._plans.choices[piece]))
            plan = self._plans.with_choice(plan, piece, number)
        return plan

    def _downhill(self, plan: Plan) -> None:
        """Go to better plans until there is none near."""
        cost = self._plans.cost(plan)
        better: tuple[Cost, Plan] | None = None if cost is None else (cost, plan)
        while True:
            if better is not None:
                cost, plan = better
                self._seen[plan] = cost
            found = min(self._around(plan), default=None)
            if found is None or (cost is not None and found >= (cost, plan)):
                return
            better = found

    def _around(self, plan: Plan) -> Iterator[tuple[Cost, Plan]]:
        for other in self._near(plan):
            cost = self._plans.cost(other)
            if cost is not None:
                yield cost, other

    def _near(self, plan: Plan) -> Iterator[Plan]:
        """Yield plans with one other choice, or with two pieces in each other's place."""
        plans = self._plans
        for piece, ways in enumerate(plans.choices):
            for number in range(len(ways)):
                if number != plan[piece]:
                    yield plans.with_choice(plan, piece, number)
