"""The search for the best plan: from several starts downhill, then again from near the best.

Nothing in it depends on time, on the order of sets, or on hashes: equal inputs give equal plans.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from random import Random

from bt_orchestrator.planning.plans import Cost, Plan, Plans

KICKED = 3
"""Choices that are drawn anew in a kick."""


class Search:
    """A search over the plans of a recipe."""

    def __init__(self, plans: Plans) -> None:
        self._plans = plans
        self.best: tuple[Cost, Plan] | None = None
        """None: all that was tried gets stuck."""

    def run(self, starts: Iterable[Plan], kicks: int) -> None:
        """Look for the best plan.

        :param kicks: times that it is begun again from near the best plan
        """
        for start in dict.fromkeys(starts):
            self._downhill(start)
        random = Random(0)  # the same draws in every run
        for _ in range(kicks):
            if self.best is not None:
                self._downhill(self._kicked(self.best[1], random))

    def _kicked(self, plan: Plan, random: Random) -> Plan:
        ways = self._plans.choices
        free = [piece for piece in range(len(ways)) if len(ways[piece]) > 1]
        for piece in random.sample(free, min(len(free), KICKED)):
            plan = self._plans.with_choice(plan, piece, random.randrange(len(ways[piece])))
        return plan

    def _downhill(self, plan: Plan) -> None:
        """Go to better plans until there is none near."""
        cost = self._plans.cost(plan)
        goes_on = True
        while goes_on:
            goes_on = False
            for near in (self._moves, self._swaps):
                for other in near(plan):
                    least = self._plans.at_best(other)
                    if least is None or (cost is not None and least >= cost):
                        continue
                    found = self._plans.cost(other)
                    if found is not None and (cost is None or found < cost):
                        cost, plan, goes_on = found, other, True
                        break
                if goes_on:
                    break
        if cost is not None and (self.best is None or (cost, plan) < self.best):
            self.best = cost, plan

    def _moves(self, plan: Plan) -> Iterator[Plan]:
        """Yield plans with one other choice, those of the slowest sections first."""
        slowest = self._plans.slowest(plan)
        for piece in sorted(range(len(plan)), key=lambda one: one not in slowest):
            for number in range(len(self._plans.choices[piece])):
                if number != plan[piece]:
                    yield self._plans.with_choice(plan, piece, number)

    def _swaps(self, plan: Plan) -> Iterator[Plan]:
        """Yield plans in which a piece of a slowest section has changed places with another."""
        plans = self._plans
        for one in sorted(plans.slowest(plan)):
            here = plans.choices[one][plan[one]].section
            for other in range(len(plan)):
                there = plans.choices[other][plan[other]].section
                if there == here:
                    continue
                to, back = plans.best_in(one, there, plan[one]), None
                if to is not None:
                    back = plans.best_in(other, here, plan[other])
                if to is not None and back is not None:
                    yield plans.with_choice(plans.with_choice(plan, one, to), other, back)
