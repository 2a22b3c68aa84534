"""The declarations of recipes for their orders: read without a cell, and without planning."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import chain
from pathlib import Path

from bt_orchestrator.base.errors import Finding, Refused
from bt_orchestrator.extensions.recipes.reading.drafts import RecipeDraft
from bt_orchestrator.extensions.recipes.reading.shelf import shelved_at
from bt_orchestrator.script.fields import file_fields
from bt_orchestrator.script.lookup import scripts_in
from bt_orchestrator.script.orders.by_recipe import DeclaredRecipe, DeclaredVersion
from bt_orchestrator.script.orders.recipe_keys import RECIPE
from bt_orchestrator.script.parameters import read_parameters
from bt_orchestrator.script.read_once import ReadOnce
from bt_orchestrator.script.report import Report
from bt_orchestrator.script.source_text import read_text
from bt_orchestrator.script.yaml_nodes import ListNode, MapNode, Node, Scalar


class DeclaredRecipes:
    """The recipes in some folders; an unchanged file is read once."""

    def __init__(self, folders: Sequence[Path]) -> None:
        """Prepare; nothing is read."""
        self._folders = tuple(folders)
        self._files = ReadOnce(declared_version)

    def read(self) -> list[DeclaredRecipe]:
        """Return those that orders can name, by name."""
        files = chain.from_iterable(map(scripts_in, self._folders))
        return list(recipes_of(self._files.of(files)))


def declared_version(path: Path) -> DeclaredVersion:
    """Read what a file declares.

    :raises Refused: it is no recipe
    """
    file = shelved_at(path)
    if file is None:
        hint = 'a recipe begins with `recipe: NAME`'
        raise Refused([Finding(str(path), 1, 1, 'this is no recipe', hint)])
    report = Report(str(path))
    try:
        draft = RecipeDraft(file_fields(read_text(path), RECIPE, report))
        read_parameters(draft, report)
        report.refuse()
    except Refused:
        return DeclaredVersion(file.name, file.version, {}, {}, has_mistakes=True)
    operations = dict(_operations(draft.fields.node, 'operations'))
    return DeclaredVersion(file.name, file.version, draft.params, operations)


def recipes_of(declared: Iterable[DeclaredVersion]) -> Iterator[DeclaredRecipe]:
    """Yield recipes by name; of a version that is there twice the first counts.

    One whose newest version has mistakes is left out: an order of it would be refused.
    """
    found: dict[str, dict[int, DeclaredVersion]] = {}
    for one in declared:
        found.setdefault(one.name, {}).setdefault(one.version, one)
    for name, versions in sorted(found.items()):
        if not versions[max(versions)].has_mistakes:
            sound = [one for _, one in sorted(versions.items()) if not one.has_mistakes]
            yield DeclaredRecipe(name, tuple(sound))


def _operations(node: MapNode, key: str) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Yield operations with what they do; an order of one with mistakes tells them."""
    for one in _listed(node, key):
        if isinstance(one, MapNode):
            yield from _operations(one, 'repeat')
            ids, does = (tuple(_texts(one, key)) for key in ('id', 'do'))
            if ids and does:
                yield ids[0], does


def _texts(node: MapNode, key: str) -> Iterator[str]:
    return (one.text for one in _listed(node, key) if isinstance(one, Scalar) and one.text)


def _listed(node: MapNode, key: str) -> Sequence[Node]:
    """Return the members of a list, or what stands for it."""
    entry = node.find(key)
    if entry is None:
        return ()
    return entry.value.items if isinstance(entry.value, ListNode) else (entry.value,)
