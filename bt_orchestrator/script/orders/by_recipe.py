"""Orders by recipe as the core sees them; what generates their scripts is an extension."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Protocol, cast

from bt_orchestrator.base.errors import Refused
from bt_orchestrator.base.extending import RECIPES
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.jobs.order import RecipeChoice
from bt_orchestrator.model.recipe import Recipe
from bt_orchestrator.model.script import Parameter, Script
from bt_orchestrator.ports import ActionTypes, Generating, MadeScript
from bt_orchestrator.script.composing import compose
from bt_orchestrator.script.orders.order_file import OrderPlaces
from bt_orchestrator.script.report import Report
from bt_orchestrator.script.source_text import read_text
from bt_orchestrator.script.starter.starter_plan import Plan
from bt_orchestrator.script.yaml_nodes import MapNode


@dataclass(frozen=True)
class DeclaredVersion:
    """The head of one version of a recipe, and what its operations do."""

    name: str
    """By which an order names the recipe."""
    version: int
    params: Mapping[str, Parameter]
    operations: Mapping[str, tuple[str, ...]]
    """By id, the capabilities; any of them does it."""
    has_mistakes: bool = False
    """In what is read here: then nothing of it can be used."""


@dataclass(frozen=True)
class DeclaredRecipe:
    """A recipe, with the versions of it that can be ordered."""

    name: str
    versions: tuple[DeclaredVersion, ...]
    """The newest last."""

    @property
    def newest(self) -> DeclaredVersion:
        """The version that is made where an order names none."""
        return self.versions[-1]


class Maker(Protocol):
    """Makes the scripts of orders by recipe for one cell, and keeps what it made."""

    def ordered(self, choice: RecipeChoice, places: OrderPlaces) -> Script:
        """Return the script of an order.

        :param places: of the order
        :raises Refused: with the reasons: none can be made, or there is no such recipe
        """

    def script(self, choice: RecipeChoice, without: frozenset[str]) -> MadeScript | Refused:
        """Return the text of what is made, or why nothing is.

        :param without: components that are out of service
        """


class Recipes(Protocol):
    """The interface from the core to the extension."""

    def read_recipe(self, path: Path, cell: Cell, types: ActionTypes) -> Recipe:
        """Read a recipe; raises Refused with every mistake in it."""

    def orderable(self, folders: Sequence[Path]) -> Callable[[], list[DeclaredRecipe]]:
        """Return what reads the recipes in some folders that orders can name, by name."""

    def names(self, folders: Sequence[Path]) -> Set[str]:
        """Return the names of all recipes in some folders."""

    def maker(self, cell: Cell, types: ActionTypes, folders: Sequence[Path]) -> Maker:
        """Return what makes scripts in this process, of the recipes in some folders."""

    def generating(
        self, cell: Cell, folders: Sequence[Path], soon: Callable[[Callable[[], None]], None]
    ) -> Generating:
        """Return what makes scripts in a process that starts with the first order by recipe."""

    def starter(
        self, name: str, plan: Plan, schemas: Mapping[str, str], types: ActionTypes
    ) -> dict[str, str]:
        """Return the texts of a starter cell with a recipe, and the script generated from it."""


def recipes() -> Recipes:
    """Return the extension.

    :raises ExtensionMissing: says what to install
    """
    RECIPES.demand()
    return cast('Recipes', import_module(f'{RECIPES.room}.generating.extension'))


def is_recipe(path: Path) -> bool:
    """Tell whether a file is meant as a recipe; one that cannot be read is none."""
    try:
        root = compose(read_text(path), Report(str(path)))
    except Refused:
        return False
    keys = {entry.key.text for entry in root.entries} if isinstance(root, MapNode) else set()
    of_others = {'order', 'quantity', 'sections'}
    return 'operations' in keys or ('recipe' in keys and not keys & of_others)
