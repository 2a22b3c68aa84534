"""A plan: a choice for every piece, and what it costs."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import NamedTuple

from bt_orchestrator.model.cell import CONVEYOR
from bt_orchestrator.planning.pieces import Choice, Pieces
from bt_orchestrator.planning.reach import Reach
from bt_orchestrator.planning.section_lists import NOTHING, Entry, Listed, listed

Plan = tuple[int, ...]
"""By piece: the number of its choice."""


_TRIED = 4
"""Plans, for each one that is asked for, whose flags are tried."""


class Cost(NamedTuple):
    """What a plan costs; the first that differs decides."""

    moved: int
    """Operations that are elsewhere than in the script that is kept."""
    us: Fraction
    """Microseconds for each item."""
    spread: int
    """Sum of the squares of the times of the sections."""
    order: int
    """How far it is from what was declared first."""


class Plans:
    """All plans of a recipe for a cell."""

    def __init__(
        self,
        reach: Reach,
        move_us: int,
        *,
        moved: Callable[[Choice], int] = lambda _: 0,
        closed_us: Callable[[Plan], Fraction | None] | None = None,
    ) -> None:
        """Take the choices that are within reach.

        :param moved: how many operations of a choice are elsewhere than before
        :param closed_us: the closed form for a plan with flags, which sections alone do not tell;
            None: it gets stuck
        """
        self.pieces: Pieces = reach.pieces
        self.reach = reach
        self.move_us = move_us
        self.least_move_us = 0 if set.intersection(*map(set, reach.sections)) else move_us
        """Nothing moves if all is done in one section."""
        self._closed_us = closed_us
        self.choices = [
            [one for one in ways if one.section in within]
            for ways, within in zip(self.pieces.choices, reach.sections, strict=True)
        ]
        self.moved = [[moved(one) for one in ways] for ways in self.choices]
        self._lists: dict[tuple[tuple[int, int], ...], Listed] = {}
        self._costs: dict[Plan, Cost | None] = {}
        self._at_best: dict[Plan, Cost | None] = {}
        self.before: list[list[int]] = [[] for _ in self.choices]
        """By piece: those that are done in no section behind it."""
        self.behind: list[list[int]] = [[] for _ in self.choices]
        """By piece: those that are done in no section before it."""
        for first, second in reach.links:
            self.before[second].append(first)
            self.behind[first].append(second)
        self.shared = self._find_shared()
        number_of = self.pieces.number_of
        self._held = [
            (one, number_of[one.giver], [number_of[taker] for taker in one.takers])
            for one in reach.held
        ]

    def _find_shared(self) -> list[list[tuple[tuple[str, int], ...]]]:
        """Return, by piece and choice, what else may want its spaces, and for how long it does."""
        where: dict[str, set[int]] = {CONVEYOR: {0}}
        for choice in (one for ways in self.choices for one in ways):
            for name in choice.spaces:
                where.setdefault(name, set()).add(choice.section)
        shared = {name for name, sections in where.items() if len(sections) > 1}
        self.shares = bool(shared)
        """Whether sections may share something; the closed form is a bound then."""
        return [[_uses(one, shared) for one in ways] for ways in self.choices]

    # --- what a plan is ---------------------------------------------------------------------

    def of(self, plan: Plan) -> list[Choice]:
        """Return the choices of a plan, by piece."""
        return [ways[number] for ways, number in zip(self.choices, plan, strict=True)]

    def lists(self, plan: Plan) -> dict[int, Listed]:
        """Return the lists of a plan, by section, along the belt."""
        found: dict[int, list[tuple[int, int]]] = {}
        for piece, number in enumerate(plan):
            found.setdefault(self.choices[piece][number].section, []).append((piece, number))
        return {section: self._list(tuple(found[section])) for section in sorted(found)}

    def _list(self, key: tuple[tuple[int, int], ...]) -> Listed:
        known = self._lists.get(key)
        if known is None:
            entries = [Entry(piece, self.choices[piece][number]) for piece, number in key]
            known = self._lists[key] = listed(self.pieces, entries) if entries else NOTHING
        return known

    def cost(self, plan: Plan) -> Cost | None:
        """Return what a plan costs; None: it gets stuck, or no script can say it."""
        least = self.at_best(plan)
        if self._closed_us is None or least is None:
            return least
        if plan not in self._costs:
            us = self._closed_us(plan)
            self._costs[plan] = None if us is None else least._replace(us=us)
        return self._costs[plan]

    def at_best(self, plan: Plan) -> Cost | None:
        """Return what a plan costs by its sections alone: flags may make it slower.

        None: a device would have to keep what it cannot.
        """
        if plan not in self._at_best:
            self._at_best[plan] = None if self._cannot_keep(plan) else self._of_sections(plan)
        return self._at_best[plan]

    def _of_sections(self, plan: Plan) -> Cost:
        lists = self.lists(plan)
        move_us = self.move_us if len(lists) > 1 else 0  # a belt of one section does not move
        times = [one.us(move_us) for one in lists.values()]
        us = Fraction(max([move_us, *times, *self._alone(plan)]))
        moved = sum(ways[number] for ways, number in zip(self.moved, plan, strict=True))
        return Cost(moved, us, sum(one * one for one in times), sum(plan))

    def _cannot_keep(self, plan: Plan) -> bool:
        """Tell whether a device would have to keep what it cannot.

        For two operations, because there is one flag; for too many items, because those that need
        it are too far; or once more in each round (semantics 3.9, 4.1).
        """
        kept: set[tuple[str, str]] = set()
        for one, giver, takers in self._held:
            choice = self.choices[giver][plan[giver]]
            for member in choice.members:
                if not one.is_kept_by(member):
                    continue
                others = [self.choices[taker][plan[taker]] for taker in takers]
                last = max(other.section for other in others)
                key = member.component.name, one.name
                if (
                    key in kept
                    or last - choice.section > member.capability.holds[one.name]
                    or any(other.repeats for other in (choice, *others))
                ):
                    return True
                kept.add(key)
        return False

    def _alone(self, plan: Plan) -> list[int]:
        """Return how long all tasks take that share something, never two at once."""
        if not self.shares:
            return []
        took: dict[str, int] = {}
        for piece, number in enumerate(plan):
            for name, us in self.shared[piece][number]:
                took[name] = took.get(name, 0) + us
        if CONVEYOR in took:
            took[CONVEYOR] += self.move_us
        return list(took.values())

    def slowest(self, plan: Plan) -> set[int]:
        """Return the pieces of the sections that take longest."""
        times = {number: one.us(self.move_us) for number, one in self.lists(plan).items()}
        most = max(times.values())
        return {piece for piece, one in enumerate(self.of(plan)) if times[one.section] == most}

    @property
    def has_flags(self) -> bool:
        """Tell whether sections alone do not tell how fast a plan is."""
        return self._closed_us is not None

    def is_plain(self, plan: Plan) -> bool:
        """Tell whether no other order of the lists could be faster."""
        return self._closed_us is None and all(one.is_plain for one in self.lists(plan).values())

    def best(self, count: int) -> list[tuple[Cost, Plan]]:
        """Return the best plans of those that were looked at."""
        known = ((cost, plan) for plan, cost in self._at_best.items() if cost is not None)
        costs = [(self.cost(plan), plan) for _, plan in heapq.nsmallest(_TRIED * count, known)]
        return sorted((cost, plan) for cost, plan in costs if cost is not None)[:count]

    # --- from one plan to another -----------------------------------------------------------

    def with_choice(self, plan: Plan, piece: int, number: int) -> Plan:
        """Return a plan with another choice; neighbours that stand in its way go along."""
        changed = list(plan)
        changed[piece] = number
        # What goes along may take the piece itself along, if both have to be in one section.
        self._push(changed, piece, self.before, up=False)
        self._push(changed, piece, self.behind, up=True)
        return tuple(changed)

    def _push(self, plan: list[int], piece: int, to: Sequence[Sequence[int]], *, up: bool) -> None:
        waiting = [(piece, self.choices[piece][plan[piece]].section)]
        while waiting:
            piece, section = waiting.pop()
            for other in to[piece]:
                at = self.choices[other][plan[other]].section
                if (at < section) if up else (at > section):
                    within = self.reach.sections[other]
                    fit = [one for one in within if (one >= section if up else one <= section)]
                    at = fit[0] if up else fit[-1]
                    plan[other] = self._in(other, at, plan[other])
                    waiting.append((other, at))

    def best_in(self, piece: int, section: int, before: int) -> int | None:
        """Return a choice in a section; None: there is none."""
        if section not in self.reach.sections[piece]:
            return None
        return self._in(piece, section, before)

    def _in(self, piece: int, section: int, before: int) -> int:
        """Return a choice in a section: as before, of the same component, or else the quickest."""
        ways = self.choices[piece]
        same = ways[before].members[0].component
        return min(
            (number for number, one in enumerate(ways) if one.section == section),
            key=lambda n: (
                self.moved[piece][n],
                ways[n].members[0].component is not same,
                ways[n].us,
                n,
            ),
        )

    def first(self) -> Plan:
        """Return the plan in which everything is done as early as can be."""
        return tuple(
            self._in(piece, within[0], 0) for piece, within in enumerate(self.reach.sections)
        )

    def last(self) -> Plan:
        """Return the plan in which everything is done as late as can be."""
        return tuple(
            self._in(piece, within[-1], 0) for piece, within in enumerate(self.reach.sections)
        )


def _uses(choice: Choice, shared: set[str]) -> tuple[tuple[str, int], ...]:
    return tuple(
        (name, member.us) for member in choice.members for name in sorted(shared & member.spaces)
    )
