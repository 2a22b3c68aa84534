"""Scripts of orders by recipe that are generated between runs.

Generating runs scripts in virtual time itself, and two runs at a time are not for one process.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from bt_orchestrator.base.errors import NotRead, Refused
from bt_orchestrator.model.jobs.order import RecipeChoice
from bt_orchestrator.ports import MadeScript

Make = Callable[[RecipeChoice, frozenset[str]], MadeScript | Refused]
"""Generates the script of a recipe, without some components."""


class MadeBefore:
    """Knows what was generated, and notes what a run lacks. Implements `ports.Generating`."""

    def __init__(self, make: Make | None) -> None:
        """Begin with nothing.

        :param make: None: nothing can be generated
        """
        self._make = make
        self._made: list[tuple[RecipeChoice, frozenset[str], MadeScript | Refused]] = []
        self._lacking: list[tuple[RecipeChoice, frozenset[str]]] = []

    async def make(
        self, choices: Sequence[RecipeChoice], without: frozenset[str]
    ) -> Sequence[MadeScript | Refused]:
        """Return the script of each.

        :raises NotRead: one was not generated
        """
        known = [(choice, made) for choice, lost, made in self._made if lost == without]
        missing = [recipe for recipe in choices if all(recipe != choice for choice, _ in known)]
        if missing:
            self._lacking += [(recipe, without) for recipe in missing]
            raise NotRead(f'the script of {missing[0].words} is not worked out here')
        return [next(made for choice, made in known if choice == recipe) for recipe in choices]

    @property
    def lacks(self) -> bool:
        """Whether a run asked for something in vain that can be generated."""
        return bool(self._lacking) and self._make is not None

    def generate(self, *more: tuple[RecipeChoice, frozenset[str]]) -> None:
        """Generate what was asked for in vain, and more."""
        lacking, self._lacking = [*self._lacking, *more], []
        if self._make is not None:
            self._made += [(choice, lost, self._make(choice, lost)) for choice, lost in lacking]

    def close(self) -> None:
        """Nothing works."""
