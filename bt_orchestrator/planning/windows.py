"""Better plans by taking a few sections apart: what they do is shared out anew among them.

A search that moves one or two pieces stops where all near the slowest section are nearly full.
Some sections together have more ways, and few enough to be gone through.
"""

from __future__ import annotations

from collections.abc import Iterable, Set
from random import Random

from bt_orchestrator.planning.bound import Bound
from bt_orchestrator.planning.plans import Plan, Plans

SECTIONS = 5
"""That are taken apart together."""

NODES = 10_000
"""Choices that may be tried for one of them."""


class Windows:
    """Takes apart the slowest section with others near it, again and again.

    Nothing in it depends on time, as in the search.
    """

    def __init__(self, plans: Plans) -> None:
        self._plans = plans
        self._random = Random(0)  # the same draws in every run
        self._sections = sorted({one.section for ways in plans.choices for one in ways})

    def better(self, plan: Plan, times: int, nodes: int) -> Plan:
        """Return a plan whose slowest sections are faster, or as it was.

        :param times: sections are taken apart
        :param nodes: choices that may be tried in all
        """
        slow = self._slow(plan)
        for _ in range(times):
            if nodes <= 0:
                break
            most = slow[0][0]
            window = self._drawn(self._random.choice([n for us, n in slow if us == most]))
            part = _Part(self._plans, min(NODES, nodes), plan, window)
            part.look(most)
            nodes -= part.tried
            if part.faster is not None:
                found = self._slow(part.faster)
                if [us for us, _ in found] < [us for us, _ in slow]:
                    plan, slow = part.faster, found
        return plan

    def _drawn(self, slowest: int) -> Set[int]:
        """Return a section with some of those near it."""
        others = sorted(
            (one for one in self._sections if one != slowest),
            key=lambda one: (abs(one - slowest), one),
        )
        near = others[: 2 * SECTIONS]
        return {slowest, *self._random.sample(near, min(len(near), SECTIONS - 1))}

    def _slow(self, plan: Plan) -> list[tuple[int, int]]:
        """Return the times of the sections with their numbers, the slowest first."""
        lists = self._plans.lists(plan)
        times = ((one.us(self._plans.move_us), number) for number, one in lists.items())
        return sorted(times, reverse=True)


class _Part(Bound):
    """Looks for the first plan in which some sections do their work among them in less time."""

    def __init__(self, plans: Plans, nodes: int, plan: Plan, window: Set[int]) -> None:
        ways = plans.choices
        inside = [n for n, number in enumerate(plan) if ways[n][number].section in window]
        numbers = {
            n: [number for number, one in enumerate(ways[n]) if one.section in window]
            for n in inside
        }
        super().__init__(plans, nodes, numbers, plan)
        self._nodes, self._spared = nodes, 0

    @property
    def tried(self) -> int:
        """How many choices were tried."""
        return self._nodes - max(self._left, 0) - self._spared

    def _tries(self, piece: int) -> Iterable[int]:
        """Try first where least is to be done: most parts have a way, and one is enough."""
        ways = self._plans.choices[piece]
        return sorted(
            self._numbers[piece],
            key=lambda n: (self._work.alone_us(ways[n].section) + ways[n].us, n),
        )

    def _at_end(self) -> None:
        plan = tuple(self._chosen)
        if self._plans.at_best(plan) is not None:
            self.faster, self._spared, self._left = plan, self._left, 0
