"""What orders can name, as far as there are files of it here: scripts and recipes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from bt_orchestrator.script.declared import Declared, declared, script_files
from bt_orchestrator.script.read_once import ReadOnce
from bt_orchestrator.script.recipes.declared import (
    DeclaredRecipe,
    declared_version,
    recipe_files,
    recipes_of,
)


class OrderFiles:
    """The folders of a node; a file that stays as it is is read once.

    What cannot be read is left out, and an order of it tells why.
    """

    def __init__(self, trees: Sequence[Path] = (), recipes: Sequence[Path] = ()) -> None:
        """Prepare; nothing is read.

        :param trees: folders of scripts
        :param recipes: folders of recipes
        """
        self._trees, self._recipes = tuple(trees), tuple(recipes)
        self._of_scripts = ReadOnce(declared)
        self._of_recipes = ReadOnce(declared_version)

    def scripts(self) -> list[Declared]:
        """Return the scripts that orders can name: the first of each name."""
        return self._of_scripts.of(script_files(self._trees))

    def recipes(self) -> list[DeclaredRecipe]:
        """Return the recipes that orders can name, by name."""
        return list(recipes_of(self._of_recipes.of(recipe_files(self._recipes))))
