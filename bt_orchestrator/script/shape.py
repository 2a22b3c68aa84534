"""Telling a text that is meant as one of the users' files from any other.

Other files are never quoted: a client may name any file that the node can read, and must not see
its content.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence, Set

from bt_orchestrator.base.errors import Finding, Refused
from bt_orchestrator.script.cell_keys import CELL
from bt_orchestrator.script.keys import Table
from bt_orchestrator.script.orders.recipe_keys import OVERRIDES, RECIPE
from bt_orchestrator.script.report import START, Report, nearest
from bt_orchestrator.script.script_keys import ORDER, SCRIPT
from bt_orchestrator.script.shifts.shifts_keys import REASONS, SHIFTS
from bt_orchestrator.script.yaml_nodes import ListNode, MapNode, Node, Scalar, quoted

KINDS = (CELL, SCRIPT, ORDER, RECIPE, OVERRIDES, SHIFTS, REASONS)

_MISSPELT = 0.8
"""How alike a word and a key are at least, if the key is meant."""

_COMPARED = 100
"""Words that are compared with the keys: a file of other things may have any number."""

_INDENTED = re.compile(r'(?m)^([ ]*)(?![#\s]|---|%)\S')
_KEY = re.compile(r'([ {]*)["\']?([\w-]{1,64})["\']?[ ]*:(?=\s|$)')


def refuse_strangers(
    text: str, root: Node | None, report: Report, tables: Iterable[Table], what: str = ''
) -> None:
    """Refuse a text that is meant as something else.

    :param root: what it says as YAML; None: it is none, or the file is empty
    :param report: what YAML itself forbids in it
    :param what: how to name what it is not, if not by the table
    :raises Refused: it is, and nothing in it is told
    """
    tables = tuple(tables)
    table = tables[0]
    other = _other_kind(root, tables)
    if other is not None:
        words = f'this is {other.name}, and {what or table.name} is expected'
        hint = _how_to_order(root, table, other) or 'check which file is named'
        raise Refused([Finding(report.file, START.line, START.column, words, hint)])
    kind = _stranger(text, root, tables)
    if kind is None:
        return
    words = f'this is not {what or table.name}, but {kind}'
    raise Refused([Finding(report.file, START.line, START.column, words, table.hint)])


def _other_kind(root: Node | None, tables: tuple[Table, ...]) -> Table | None:
    """Return which other one of the users' files a text is: it has keys of that one alone."""
    if not isinstance(root, MapNode):
        return None
    keys = {entry.key.text for entry in root.entries}
    expected = {name for table in tables for name in table.by_name}
    others = [
        other
        for other in KINDS
        if other not in tables
        and keys & (other.by_name.keys() - expected)
        and not keys & (expected - other.by_name.keys())
    ]
    return max(others, key=lambda other: _likeness(keys, other), default=None)


def _how_to_order(root: Node | None, expected: Table, other: Table) -> str:
    """Say which work order makes the product of a script or recipe; empty: the file is neither."""
    key = {SCRIPT.name: 'script', RECIPE.name: 'recipe'}.get(other.name)
    entry = root.find(key) if key is not None and isinstance(root, MapNode) else None
    if expected is not ORDER or entry is None or not isinstance(entry.value, Scalar):
        return ''
    return f'name a file with {quoted(f"{key}: {entry.value.text}")} and `quantity`'


def _likeness(keys: Set[str], table: Table) -> tuple[int, bool]:
    """Return how many keys of a table a text has, and whether the table needs one of them."""
    own = table.by_name.keys() & keys
    return len(own), not own.isdisjoint(key.name for key in table.keys if key.required)


def _stranger(text: str, root: Node | None, tables: tuple[Table, ...]) -> str | None:
    """Say what a text is, if it is not meant as what the tables describe."""
    if isinstance(root, MapNode):
        keys = [entry.key.text for entry in (*root.entries, *root.repeated)]
        is_meant = _are_meant(keys, tables) or not (keys or root.lost)
        return None if is_meant else 'a mapping of other keys'
    if isinstance(root, ListNode):
        return 'a list'
    if root is not None:
        return 'text' if root.text else None
    return None if not _INDENTED.search(text) or _are_meant([*_keys(text)], tables) else 'no YAML'


def _are_meant(keys: Sequence[str], tables: tuple[Table, ...]) -> bool:
    known = {name for table in tables for name in (*table.by_name, *table.misplaced)}
    needed = [
        name
        for table in tables
        for name in (*(key.name for key in table.keys if key.required), *table.one_of)
    ]
    some = keys[:_COMPARED]
    return not known.isdisjoint(keys) or any(nearest(key, needed, _MISSPELT) for key in some)


def _keys(text: str) -> Iterator[str]:
    """Yield what looks like the outermost keys of a text that is no YAML."""
    text = text.removeprefix('\ufeff')
    first = _INDENTED.search(text)
    indent = len(first[1]) if first else 0
    for line in text.splitlines():
        key = _KEY.match(line)
        if key is not None and (len(key[1]) == indent or '{' in key[1]):
            yield key[2]
