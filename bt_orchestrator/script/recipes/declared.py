"""What recipes declare for their orders: read without a cell, and without planning anything."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from bt_orchestrator.errors import Refused
from bt_orchestrator.model.script import Parameter
from bt_orchestrator.script.fields import file_fields
from bt_orchestrator.script.parameters import read_parameters
from bt_orchestrator.script.recipes.drafts import RecipeDraft
from bt_orchestrator.script.recipes.recipe_keys import RECIPE
from bt_orchestrator.script.recipes.shelf import shelved
from bt_orchestrator.script.report import Report
from bt_orchestrator.script.source_text import read_text


@dataclass(frozen=True)
class DeclaredRecipe:
    """The head of a recipe."""

    name: str
    """By which an order names it."""
    versions: tuple[int, ...]
    """The newest last."""
    params: Mapping[str, Parameter]
    """Of the newest version."""


def declared_recipes(folders: Sequence[Path]) -> Iterator[DeclaredRecipe]:
    """Yield the recipes of some folders by name; what cannot be read is left out."""
    found: dict[str, dict[int, Path]] = {}
    for one in shelved(folders):
        found.setdefault(one.name, {}).setdefault(one.version, one.path)
    for name in sorted(found):
        versions = sorted(found[name])
        try:
            params = _params(found[name][versions[-1]])
        except Refused:
            continue
        yield DeclaredRecipe(name, tuple(versions), params)


def _params(path: Path) -> Mapping[str, Parameter]:
    """Read the parameters of a recipe.

    :raises Refused: there is a mistake in them
    """
    report = Report(str(path))
    draft = RecipeDraft(file_fields(read_text(path), RECIPE, report))
    read_parameters(draft, report)
    report.refuse()
    return draft.params
