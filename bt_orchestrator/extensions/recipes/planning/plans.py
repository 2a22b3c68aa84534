"""All plans of a recipe for a cell; a plan is a choice for every piece."""

from __future__ import annotations

from collections.abc import Callable

from bt_orchestrator.extensions.recipes.planning.pieces import Choice, Pieces
from bt_orchestrator.extensions.recipes.planning.reach import Reach
from bt_orchestrator.extensions.recipes.planning.section_lists import Entry, Listed, listed
from bt_orchestrator.model.cell import CONVEYOR

Plan = tuple[int, ...]
"""By piece: the number of its choice."""


class Plans:
    """All plans of a recipe for a cell."""

    def __init__(
        self, reach: Reach, move_us: int, *, moved: Callable[[Choice], int] = lambda _: 0
    ) -> None:
        """Take the choices that are within reach.

        :param moved: how many operations of a choice are elsewhere than before
        """
        self.pieces: Pieces = reach.pieces
        self.reach = reach
        self.held = reach.held
        self.move_us = move_us
        self.choices = [
            [one for one in ways if one.section in within]
            for ways, within in zip(self.pieces.choices, reach.sections, strict=True)
        ]
        self.moved = [[moved(one) for one in ways] for ways in self.choices]
        self.shared = self._find_shared()
        """The things that components of several sections may use; the closed form is a bound then.
        """

    def _find_shared(self) -> list[str]:
        where: dict[str, set[int]] = {CONVEYOR: {0}}
        for choice in (one for ways in self.choices for one in ways):
            for name in choice.spaces:
                where.setdefault(name, set()).add(choice.section)
        return sorted(name for name, sections in where.items() if len(sections) > 1)

    def of(self, plan: Plan) -> list[Choice]:
        """Return the choices of a plan, by piece."""
        return [ways[number] for ways, number in zip(self.choices, plan, strict=True)]

    def lists(self, plan: Plan) -> dict[int, Listed]:
        """Return the lists of a plan, by section, along the belt."""
        entries: dict[int, list[Entry]] = {}
        for piece, choice in enumerate(self.of(plan)):
            entries.setdefault(choice.section, []).append(Entry(piece, choice))
        return {section: listed(self.pieces, entries[section]) for section in sorted(entries)}
