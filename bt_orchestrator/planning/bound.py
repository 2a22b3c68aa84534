"""The proof that no binding is faster, or a faster one: branch and bound, limited by steps."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction

from bt_orchestrator.planning.pieces import Choice
from bt_orchestrator.planning.plans import Plan, Plans


class Bound:
    """Looks for a plan that is faster than a time, through all that could be.

    A part of a plan is given up when one section, or something that is shared, already takes as
    long; or when the sections have no room for the work that is left.
    """

    def __init__(
        self,
        plans: Plans,
        nodes: int,
        numbers: Mapping[int, Sequence[int]] | None = None,
        plan: Plan | None = None,
    ) -> None:
        """Prepare.

        :param nodes: choices that may be tried
        :param numbers: pieces that may be done elsewhere, with the choices of each; None: all
        :param plan: where the others are done
        """
        self._plans = plans
        self._left = nodes
        self.is_proven = True
        """There is no faster plan than those that were found."""
        self.faster: Plan | None = None
        """The fastest plan that was found, if there was one."""
        ways = plans.choices
        self._numbers = numbers or {n: range(len(choices)) for n, choices in enumerate(ways)}
        # What has no choice comes first, then what takes longest: it shows early what is too slow.
        self._order = sorted(
            self._numbers,
            key=lambda n: (len(self._numbers[n]) > 1, -min(c.us for c in self._choices(n)), n),
        )
        self._sections = sorted({one.section for n in self._numbers for one in self._choices(n)})
        self._work = _Work(self._sections, plans.least_move_us)
        self._later_us, self._later_belt_us = self._least_later()
        rank = {piece: rank for rank, piece in enumerate(self._order)}
        self._not_behind: list[list[int]] = [[] for _ in ways]
        self._not_before: list[list[int]] = [[] for _ in ways]
        for first, second in plans.reach.links:
            if rank.get(first, -1) < rank.get(second, -1):
                self._not_before[second].append(first)
            else:
                self._not_behind[first].append(second)
        self._chosen = [0] * len(ways) if plan is None else list(plan)
        self._most_us = 0

    def look(self, us: Fraction | int) -> None:
        """Look for plans that take less than so many microseconds for an item."""
        self._most_us = math.ceil(us) - 1
        self._from(0)

    def _least_later(self) -> tuple[list[int], list[int]]:
        """Return, by rank, the least work that is left from there on, and that on the belt."""
        later, belt = [0], [0]
        for piece in reversed(self._order):
            ways = self._choices(piece)
            alone = all(one.is_alone for one in ways)
            later.append(later[-1] + (min(one.us for one in ways) if alone else 0))
            belt.append(belt[-1] + (min(one.belt_us for one in ways) if alone else 0))
        return later[::-1], belt[::-1]

    def _from(self, rank: int) -> None:
        if not self._work.has_room(self._most_us, self._later_us[rank], self._later_belt_us[rank]):
            return
        if rank == len(self._order):
            self._at_end()
            return
        piece = self._order[rank]
        for number in self._tries(piece):
            choice = self._plans.choices[piece][number]
            if not self._fits(piece, choice.section):
                continue
            self._left -= 1
            if self._left < 0:
                self.is_proven = False
                return
            shared = self._plans.shared[piece][number]
            self._work.add(choice, shared)
            if self._work.takes_at_most(self._most_us, choice, shared):
                self._chosen[piece] = number
                self._from(rank + 1)
            self._work.remove(choice, shared)

    def _choices(self, piece: int) -> list[Choice]:
        return [self._plans.choices[piece][number] for number in self._numbers[piece]]

    def _tries(self, piece: int) -> Iterable[int]:
        """Return the numbers of the choices in the order in which they are tried."""
        return self._numbers[piece]

    def _fits(self, piece: int, section: int) -> bool:
        ways, chosen = self._plans.choices, self._chosen
        return all(
            ways[one][chosen[one]].section <= section for one in self._not_before[piece]
        ) and all(ways[one][chosen[one]].section >= section for one in self._not_behind[piece])

    def _at_end(self) -> None:
        plan = tuple(self._chosen)
        if self._plans.at_best(plan) is None:
            return  # in no order
        cost = self._plans.cost(plan)
        if cost is not None and cost.us <= self._most_us:
            self.faster, self._most_us = plan, math.ceil(cost.us) - 1
        elif not self._plans.is_plain(plan):
            self.is_proven = False  # in another order it might be as fast as its parts


class _Work:
    """How long what was chosen takes, at least."""

    def __init__(self, sections: list[int], move_us: int) -> None:
        self._move_us = move_us
        self._alone = dict.fromkeys(sections, 0)
        """Microseconds of what runs beside nothing, by section."""
        self._belt = dict.fromkeys(sections, 0)
        """The same, of what needs the belt."""
        self._beside: dict[tuple[int, str], int] = {}
        """Microseconds of what may run beside something, by section and space."""
        self._shared: dict[str, int] = {}

    def alone_us(self, section: int) -> int:
        """Return how long a section takes for what runs beside nothing."""
        return self._alone[section]

    def add(self, choice: Choice, shared: tuple[tuple[str, int], ...]) -> None:
        """Add a choice."""
        self._change(choice, shared, 1)

    def remove(self, choice: Choice, shared: tuple[tuple[str, int], ...]) -> None:
        """Take a choice back."""
        self._change(choice, shared, -1)

    def _change(self, choice: Choice, shared: tuple[tuple[str, int], ...], sign: int) -> None:
        section = choice.section
        if choice.is_alone:
            self._alone[section] += sign * choice.us
            self._belt[section] += sign * choice.belt_us
        else:
            for space in choice.spaces:
                key = section, space
                self._beside[key] = self._beside.get(key, 0) + sign * choice.us
        for name, us in shared:
            self._shared[name] = self._shared.get(name, 0) + sign * us

    def takes_at_most(
        self, most_us: int, choice: Choice, shared: tuple[tuple[str, int], ...]
    ) -> bool:
        """Tell whether nothing that a choice has changed takes longer."""
        section = choice.section
        whole = self._alone[section]
        if not choice.is_alone:
            whole += max(self._beside[section, space] for space in choice.spaces)
        rests = self._belt[section] + (choice.belt_us if not choice.is_alone else 0)
        if whole > most_us or (choice.needs_belt and rests + self._move_us > most_us):
            return False
        return all(self._shared[name] <= most_us for name, _ in shared)

    def has_room(self, most_us: int, later_us: int, later_belt_us: int) -> bool:
        """Tell whether the sections have time for the work that is left."""
        if self._move_us > most_us:
            return False
        room = sum(most_us - us for us in self._alone.values())
        belt = sum(most_us - self._move_us - us for us in self._belt.values())
        return later_us <= room and later_belt_us <= belt
