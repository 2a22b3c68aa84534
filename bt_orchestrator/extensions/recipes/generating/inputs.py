"""The sources of a generated script: the files that the user names."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from bt_orchestrator.extensions.recipes.reading.overrides_file import read_overrides
from bt_orchestrator.extensions.recipes.reading.recipe_file import parse_recipe, read_recipe
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.codec import digest, digest_of, to_plain
from bt_orchestrator.model.recipe import Overrides, Recipe
from bt_orchestrator.model.script import MadeFrom
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.script.cell_file import parse_cell, read_cell

NO_OVERRIDES = Overrides()


@dataclass(frozen=True)
class Inputs:
    """A recipe and a cell, and what an engineer decided about both."""

    cell: Cell
    recipe: Recipe
    overrides: Overrides
    types: ActionTypes

    @property
    def able(self) -> frozenset[str]:
        """The components that have a capability which an operation asks for."""
        wanted = {name for operation in self.recipe.operations for name in operation.do}
        components = self.cell.components.items()
        return frozenset(
            name for name, component in components if wanted & component.capabilities.keys()
        )

    @property
    def made_from(self) -> MadeFrom:
        """The origin that a script names; it lacks the digest of its text."""
        has_overrides = self.overrides != NO_OVERRIDES
        return MadeFrom(
            recipe=self.recipe.name,
            version=self.recipe.version,
            recipe_digest=digest(self.recipe),
            cell_digest=digest(self.cell),
            overrides_digest=digest_of(to_plain(self.overrides)) if has_overrides else '',
            generator=_version(),
        )


def read_inputs(recipe: Path, cell: Path, overrides: Path | None, types: ActionTypes) -> Inputs:
    """Read the files.

    :raises Refused: with every mistake in the first file that has one: each is read for the others
    """
    read = read_cell(cell, types)
    made = read_recipe(recipe, read, types)
    decided = NO_OVERRIDES if overrides is None else read_overrides(overrides, made, read)
    return Inputs(read, made, decided, types)


def inputs_of(recipe: str, cell: str, types: ActionTypes) -> Inputs:
    """Read the texts of a recipe and a cell.

    :raises Refused: with every mistake in the first one that has one
    """
    read = parse_cell(cell, 'the cell', types)
    return Inputs(read, parse_recipe(recipe, 'the recipe', read, types), NO_OVERRIDES, types)


def _version() -> str:
    try:
        return version('bt_orchestrator')
    except PackageNotFoundError:
        return ''
