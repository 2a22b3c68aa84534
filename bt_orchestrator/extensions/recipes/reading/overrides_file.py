"""Reading overrides: what an engineer decided about the script of one recipe."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.recipe import Overrides, Recipe
from bt_orchestrator.script.checks.structure import circles
from bt_orchestrator.script.fields import Fields, fields_of, file_fields
from bt_orchestrator.script.orders.recipe_keys import CHANGE, OVERRIDES
from bt_orchestrator.script.report import Report, did_you_mean, listing
from bt_orchestrator.script.source_text import read_text
from bt_orchestrator.script.task_reader import written_options
from bt_orchestrator.script.yaml_nodes import Entry, ListNode, Node, Scalar, found, quoted


def read_overrides(path: Path, recipe: Recipe, cell: Cell) -> Overrides:
    """Read the overrides of a recipe.

    :raises Refused: with every mistake in them
    """
    return parse_overrides(read_text(path), str(path), recipe, cell)


def parse_overrides(text: str, file: str, recipe: Recipe, cell: Cell) -> Overrides:
    """Read the text of overrides; the file's name stands in the findings.

    :raises Refused: with every mistake in it; what would change nothing is one
    """
    report = Report(file)
    overrides = _OverridesReader(file_fields(text, OVERRIDES, report), recipe, cell).read()
    report.refuse()
    return overrides


class _OverridesReader:
    """Reads one file of overrides."""

    def __init__(self, fields: Fields, recipe: Recipe, cell: Cell) -> None:
        self._fields = fields
        self._recipe = recipe
        self._cell = cell
        self._report = fields.report

    def read(self) -> Overrides:
        """Return the overrides; they are of use only if nothing was reported."""
        return Overrides(self._bind(), self._options(), tuple(self._order()))

    def _bind(self) -> dict[str, str]:
        bound = {}
        for entry in self._entries('bind'):
            component = entry.value.text if isinstance(entry.value, Scalar) else ''
            if not component:
                what = f'`bind` names a component for each operation, not {found(entry.value)}'
                self._report.add(entry.value.place, what, OVERRIDES.by_name['bind'].hint)
            elif self._is_known(entry.key):
                self._check_bound(entry, component)
                bound[entry.key.text] = component
        return bound

    def _check_bound(self, entry: Entry, name: str) -> None:
        wrong = misfit(entry.key.text, name, self._recipe, self._cell)
        if wrong is not None:
            self._report.add(entry.value.place, *wrong)

    def _options(self) -> dict[str, dict[str, Any]]:
        changed = {}
        for entry in self._entries('set'):
            fields = fields_of(entry.value, CHANGE, self._report)
            if self._is_known(entry.key) and fields is not None:
                changed[entry.key.text] = written_options(fields)
        return changed

    def _order(self) -> Iterator[tuple[str, ...]]:
        wanted: list[tuple[str, str]] = []
        for node in self._fields.items('order'):
            ids = tuple(scalar.text for scalar in self._ordered(node))
            wanted += pairwise(ids)
            yield ids
        waits = [(earlier, o.id) for o in self._recipe.operations for earlier in o.after]
        for circle in circles([*waits, *wanted]):
            what = f'operations would wait for each other: {", ".join(circle)}'
            place = self._fields.place('order')
            self._report.add(place, what, 'the order of the recipe has to be kept')

    def _ordered(self, node: Node) -> Iterator[Scalar]:
        items = node.items if isinstance(node, ListNode) else ()
        if len(items) < 2:
            given = 'one operation' if items else found(node)
            what = f'an order is a list of at least two operations, not {given}'
            self._report.add(node.place, what, OVERRIDES.by_name['order'].hint)
        for item in items:
            if not isinstance(item, Scalar) or not item.text:
                what = f'an order names operations, not {found(item)}'
                self._report.add(item.place, what, OVERRIDES.by_name['order'].hint)
            elif self._is_known(item):
                yield item

    def _entries(self, key: str) -> tuple[Entry, ...]:
        node = self._fields.mapping(key)
        return (*node.entries, *node.repeated) if node else ()

    def _is_known(self, name: Scalar) -> bool:
        """Tell whether the recipe has an operation; an override of nothing is a mistake."""
        wrong = unknown_operation(name.text, self._recipe, 'override for')
        if wrong is not None:
            self._report.add(name.place, *wrong)
        return wrong is None


# Whether a component can do an operation that is bound to it.


class Unbound(NamedTuple):
    """Why a binding does not hold."""

    what: str
    hint: str


def unknown_operation(name: str, recipe: Recipe, what: str) -> Unbound | None:
    """Say that a recipe has no such operation; None: it has.

    :param what: what names it: override for
    """
    if name in recipe.by_id:
        return None
    version = f'version {recipe.version} of {recipe.name}'
    hint = did_you_mean(name, recipe.by_id, 'remove it')
    return Unbound(f'{what} {quoted(name)}: no such operation in {version}', hint)


def misfit(operation_id: str, component: str, recipe: Recipe, cell: Cell) -> Unbound | None:
    """Say why a component cannot do an operation; None: it can."""
    operation = recipe.by_id[operation_id]
    able = [
        candidate.name
        for candidate in cell.components.values()
        if not candidate.capabilities.keys().isdisjoint(operation.do)
    ]
    if component in able:
        return None
    what = f'bind {operation.id}: there is no component {quoted(component)}'
    if component in cell.components:
        does = ' or '.join(f'`{capability}`' for capability in operation.do)
        what = f'bind {operation.id}: `{component}` does not have {does}'
    return Unbound(what, did_you_mean(component, able, f'only {listing(able)} can do it'))
