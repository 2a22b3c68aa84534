"""The scripts of orders by recipe: found, bound as the order says, and generated."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from bt_orchestrator.base.errors import Finding, Refused
from bt_orchestrator.extensions.recipes.generating.inputs import NO_OVERRIDES, Inputs
from bt_orchestrator.extensions.recipes.generating.making import Made, NotVouchedFor, make
from bt_orchestrator.extensions.recipes.planning.outcome import NotMade
from bt_orchestrator.extensions.recipes.reading.overrides_file import (
    misfit,
    read_overrides,
    unknown_operation,
)
from bt_orchestrator.extensions.recipes.reading.recipe_file import read_recipe
from bt_orchestrator.extensions.recipes.reading.shelf import Shelved, find_recipe
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.codec import digest, digest_of, to_plain
from bt_orchestrator.model.jobs.order import RecipeChoice
from bt_orchestrator.model.recipe import Recipe
from bt_orchestrator.model.script import Script
from bt_orchestrator.ports import ActionTypes, MadeScript
from bt_orchestrator.script.orders.order_file import OrderPlaces
from bt_orchestrator.script.orders.terms import Wrong

SCRIPTS_KEPT = 32
"""Scripts that need not be generated again while what they are made from stays the same."""


class RecipeMaker:
    """Makes the scripts of orders by recipe for one cell."""

    def __init__(self, cell: Cell, types: ActionTypes, folders: Sequence[Path]) -> None:
        """Begin with none made.

        :param folders: where recipes are looked up, in order
        """
        self._cell = cell
        self._types = types
        self._folders = folders
        self._made: OrderedDict[str, Made | NotMade | NotVouchedFor] = OrderedDict()

    def make(
        self, choice: RecipeChoice, places: OrderPlaces, without: frozenset[str] = frozenset()
    ) -> Made:
        """Make the first of the recipes that can be made.

        :param places: of the order
        :param without: components that are out of service
        :raises Refused: with the reasons of all: none can be made, or there is no such recipe
        """
        files = [find_recipe(name, choice, self._folders, places) for name in choice.recipes]
        reasons: list[Finding] = []
        for file in files:
            try:
                return self._one(file, choice, places, without)
            except Refused as refused:
                reasons += refused.findings
        raise Refused(reasons)

    def ordered(self, choice: RecipeChoice, places: OrderPlaces) -> Script:
        """Return the script of an order, as `make` makes it."""
        return self.make(choice, places).generated.script

    def script(self, choice: RecipeChoice, without: frozenset[str]) -> MadeScript | Refused:
        """Return the text of what is made, or why nothing is."""
        try:
            made = self.make(choice, OrderPlaces(f'recipe {choice.words}'), without)
        except Refused as refused:
            return refused
        name, script = f'the script of {choice.words}', made.generated.script
        return MadeScript(name, made.text, digest(script), made.made_from)

    def _one(
        self, file: Shelved, choice: RecipeChoice, places: OrderPlaces, without: frozenset[str]
    ) -> Made:
        inputs = self._inputs(file, choice, places)
        key = digest_of([to_plain(inputs.made_from), sorted(without)])
        if key not in self._made:
            self._made[key] = _made(inputs, without)
        self._made.move_to_end(key)
        if len(self._made) > SCRIPTS_KEPT:
            self._made.popitem(last=False)
        made = self._made[key]
        if isinstance(made, Made):
            return made
        reasons = made.reasons if isinstance(made, NotMade) else (str(made),)
        recipe = f'recipe {file.name} version {file.version} cannot be made'
        raise Refused([places.finding(Wrong('recipe', f'{recipe}: {why}', '')) for why in reasons])

    def _inputs(self, file: Shelved, choice: RecipeChoice, places: OrderPlaces) -> Inputs:
        """Read the files; what the order binds goes before what the overrides do.

        :raises Refused: with every mistake in them, or in what the order binds
        """
        recipe = read_recipe(file.path, self._cell, self._types)
        given = file.overrides
        overrides = NO_OVERRIDES
        if given is not None:
            overrides = read_overrides(given, recipe, self._cell)
        wrong = [places.finding(problem) for problem in _unbound(choice, recipe, self._cell)]
        if wrong:
            raise Refused(wrong)
        if choice.bind:
            overrides = replace(overrides, bind={**overrides.bind, **choice.bind})
        return Inputs(self._cell, recipe, overrides, self._types)


def _unbound(choice: RecipeChoice, recipe: Recipe, cell: Cell) -> Iterator[Wrong]:
    for operation, component in choice.bind.items():
        wrong = unknown_operation(operation, recipe, 'bind') or misfit(
            operation, component, recipe, cell
        )
        if wrong is not None:
            yield Wrong(f'bind.{operation}', *wrong)


def _made(inputs: Inputs, without: frozenset[str]) -> Made | NotMade | NotVouchedFor:
    try:
        return make(inputs, without)
    except (NotMade, NotVouchedFor) as fault:
        return fault
