"""The interface from the core to the extension: `script.orders.by_recipe.Recipes`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence, Set
from pathlib import Path

from bt_orchestrator.extensions.recipes.reading import shelf
from bt_orchestrator.extensions.recipes.reading.recipe_file import read_recipe
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.ports import ActionTypes, Generating
from bt_orchestrator.script.cell_file import CELL_FILE
from bt_orchestrator.script.orders.by_recipe import DeclaredRecipe, Maker
from bt_orchestrator.script.starter.starter_files import RECIPE_FILE, SCRIPT_FILE
from bt_orchestrator.script.starter.starter_plan import Plan

__all__ = ['read_recipe', 'orderable', 'names', 'maker', 'generating', 'starter']


def orderable(folders: Sequence[Path]) -> Callable[[], list[DeclaredRecipe]]:
    """Return what reads the recipes that orders can name; a file that stays is read once."""
    return shelf.DeclaredRecipes(folders).read


def names(folders: Sequence[Path]) -> Set[str]:
    """Return the names of all recipes in some folders."""
    return {recipe.name for recipe in shelf.shelved(folders)}


def maker(cell: Cell, types: ActionTypes, folders: Sequence[Path]) -> Maker:
    """Return what makes scripts in this process, of the recipes in some folders."""
    from bt_orchestrator.extensions.recipes.generating.ordered import RecipeMaker

    return RecipeMaker(cell, types, folders)


def generating(
    cell: Cell, folders: Sequence[Path], soon: Callable[[Callable[[], None]], None]
) -> Generating:
    """Return what makes scripts in a process that starts with the first order by recipe."""
    from bt_orchestrator.extensions.recipes.generating.process import GeneratingProcess

    return GeneratingProcess(cell, folders, soon)


def starter(
    name: str, plan: Plan, schemas: Mapping[str, str], types: ActionTypes
) -> dict[str, str]:
    """Return the texts of a starter cell with a recipe, and the script generated from it."""
    from bt_orchestrator.extensions.recipes.generating.inputs import inputs_of
    from bt_orchestrator.extensions.recipes.generating.making import make
    from bt_orchestrator.extensions.recipes.reading.starter import starter_recipe_files

    texts = starter_recipe_files(name, plan, schemas)
    made = make(inputs_of(texts[RECIPE_FILE], texts[CELL_FILE], types))
    cell, recipe, *others = texts
    return {
        **{file: texts[file] for file in (cell, recipe)},
        SCRIPT_FILE: made.text,
        **{file: texts[file] for file in others},
    }
