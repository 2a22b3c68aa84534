"""The choices of orders, as far as there are files here: scripts and recipes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from bt_orchestrator.base.extending import RECIPES
from bt_orchestrator.script.declared import Declared, declared, script_files
from bt_orchestrator.script.orders.by_recipe import DeclaredRecipe, recipes
from bt_orchestrator.script.read_once import ReadOnce


class OrderFiles:
    """The folders of a node; an unchanged file is read once.

    What cannot be read is left out, and an order of it tells why.
    """

    def __init__(self, trees: Sequence[Path] = (), folders: Sequence[Path] = ()) -> None:
        """Prepare; nothing is read.

        :param trees: folders of scripts
        :param folders: of recipes
        """
        self._trees = tuple(trees)
        self._of_scripts = ReadOnce(declared)
        has_recipes = folders and not RECIPES.missing
        self._of_recipes = recipes().orderable(folders) if has_recipes else list

    def scripts(self) -> list[Declared]:
        """Return the scripts that orders can name: the first of each name."""
        return self._of_scripts.of(script_files(self._trees))

    def recipes(self) -> list[DeclaredRecipe]:
        """Return the recipes that orders can name, by name."""
        return self._of_recipes()
