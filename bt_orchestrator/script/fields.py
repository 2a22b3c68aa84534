"""A cursor over one mapping: typed access to its keys, every mistake reported."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import chain
from typing import cast

from bt_orchestrator.base.errors import Refused
from bt_orchestrator.model.words import sentence
from bt_orchestrator.script.composing import MERGE, compose
from bt_orchestrator.script.keys import Key, Kind, Table
from bt_orchestrator.script.report import Place, Report, did_you_mean, listing, nearest
from bt_orchestrator.script.shape import refuse_strangers
from bt_orchestrator.script.yaml_nodes import (
    Entry,
    ListNode,
    MapNode,
    Node,
    Scalar,
    found,
    quoted,
    words,
)


class Fields:
    """The keys of one mapping, read by the table of its kind.

    Creating it reports unknown, misplaced and missing keys. An unknown key that is near to a known
    absent one is read as that one, so that a typing mistake has no consequences. Accessors return
    the key's default (or None) for a key that is absent or unreadable; `is_sure` tells the latter.
    """

    def __init__(self, node: MapNode, table: Table, report: Report) -> None:
        self.node = node
        self.report = report
        self.keys = table.keys
        self._table = table
        self._unsure: set[str] = set(node.doubtful)
        self._entries: dict[str, Entry] = {}
        self._misread: dict[str, Node] = {}
        self._sort()
        self._report_missing()

    def has(self, key: str) -> bool:
        """Tell whether a key was given."""
        return key in self._entries

    def is_sure(self, *keys: str) -> bool:
        """Tell whether what the accessors said of all these keys can be relied on."""
        return not self._unsure.intersection(keys)

    def doubt(self, key: str) -> None:
        """Note that a key's value turned out to be wrong: nothing is built on it."""
        self._unsure.add(key)

    def refuse(self, key: str, what: str, hint: str) -> None:
        """Report a mistake in a key's value, and build nothing on it."""
        self.doubt(key)
        self.report.add(self.place(key), what, hint)

    def unread_words(self, key: str) -> Iterator[str]:
        """Yield the words in what was written for a key, and perhaps for a misspelt one."""
        entry = self._entries.get(key)
        for node in (entry.value if entry else None, self._misread.get(key)):
            yield from words(node) if node else ()

    def place(self, key: str) -> Place:
        """Return the place of a key's value; of the mapping, if the key is absent."""
        return self._entries[key].value.place if key in self._entries else self.node.place

    def key_place(self, key: str) -> Place:
        """Return the place of a key; of the mapping, if it is absent."""
        return self._entries[key].key.place if key in self._entries else self.node.place

    def value(self, key: str) -> Node | None:
        """Return a key's value; None if it is absent or empty (reported)."""
        entry = self._entries.get(key)
        if entry is None:
            return None
        if isinstance(entry.value, Scalar) and entry.value.value is None:
            wanted = self._table.by_name[key]
            hint = wanted.hint if wanted.required else f'{wanted.hint}, or remove it'
            self.refuse(key, f'`{key}` has no value', hint)
            return None
        return entry.value

    def text(self, key: str) -> str | None:
        """Return a text as written."""
        node = self.value(key)
        if node is None:
            return None
        if not isinstance(node, Scalar):
            self._wrong_kind(key, node)
            return None
        if not node.text:
            self.refuse(key, f'`{key}` is empty', self._table.by_name[key].hint)
            return None
        return node.text

    def whole(self, key: str) -> int:
        """Return a whole number; the key has a default."""
        return cast(int, self._whole(key))

    def optional_whole(self, key: str) -> int | None:
        """Return a whole number, or None."""
        return self._whole(key)

    def seconds(self, key: str) -> float:
        """Return a number of seconds; the key has a default."""
        number = self._number(key)
        return cast(float, self._default(key)) if number is None else number

    def share(self, key: str) -> float | None:
        """Return a number from 0 to 1, or None."""
        return self._number(key)

    def timeout(self, key: str, default: float | None) -> float | None:
        """Return a number of seconds, None for the word none, or what holds when absent."""
        node = self._entries[key].value if key in self._entries else None
        if isinstance(node, Scalar) and node.text == 'none':
            return None
        number = self._number(key)
        return default if number is None else number

    def switch(self, key: str) -> bool:
        """Return true or false."""
        node = self.value(key)
        if isinstance(node, Scalar) and isinstance(node.value, bool):
            return node.value
        if node is not None:
            self._wrong_kind(key, node)
        return cast(bool, self._default(key))

    def choice(self, key: str) -> str | None:
        """Return one of the key's words; its default if it was not given."""
        text = self.text(key)
        choices = self._table.by_name[key].choices
        if text is None or text in choices:
            return cast('str | None', self._default(key)) if text is None else text
        hint = did_you_mean(text, choices, f'write one of {listing(choices)}')
        self.refuse(key, f'`{key}` cannot be {quoted(text)}', hint)
        return cast('str | None', self._default(key))

    def items(self, key: str) -> tuple[Node, ...]:
        """Return the members of a list; none if it is absent."""
        node = self.value(key)
        if isinstance(node, ListNode):
            again = (entry.value for entry in self._repeated(key))
            more = (value.items for value in again if isinstance(value, ListNode))
            return tuple(chain(node.items, *more))
        if node is not None:
            self._wrong_kind(key, node)
        return ()

    def names(self, key: str) -> tuple[Scalar, ...]:
        """Return the texts of a list, or the one that stands for it; none if it is absent."""
        node = self.value(key)
        if node is None:
            return ()
        items = node.items if isinstance(node, ListNode) else (node,)
        texts: list[Scalar] = []
        for item in items:
            if isinstance(item, Scalar) and item.text:
                texts.append(item)
            else:
                self._wrong_kind(key, item)
        return tuple(texts)

    def mapping(self, key: str) -> MapNode | None:
        """Return a mapping."""
        node = self.value(key)
        if node is not None and not isinstance(node, MapNode):
            self._wrong_kind(key, node)
        elif node is not None and not node.is_complete:
            self.doubt(key)
        return self._whole_mapping(key, node) if isinstance(node, MapNode) else None

    def table(self, key: str) -> Fields | None:
        """Return a cursor over the mapping that is a key's value."""
        node = self.mapping(key)
        return Fields(node, self._table.by_name[key].of[0], self.report) if node else None

    def tables(self, key: str) -> Iterator[Fields]:
        """Yield a cursor over every mapping in a list."""
        table = self._table.by_name[key].of[0]
        for item in self.items(key):
            fields = fields_of(item, table, self.report)
            if fields is None:
                self.doubt(key)
            else:
                yield fields

    def _repeated(self, key: str) -> tuple[Entry, ...]:
        return tuple(entry for entry in self.node.repeated if entry.key.text == key)

    def _whole_mapping(self, key: str, node: MapNode) -> MapNode:
        """Return a mapping with what was written for the same key again."""
        for again in self._repeated(key):
            if isinstance(again.value, MapNode):
                node = node.joined(again.value)
        return node

    def _sort(self) -> None:
        for entry in self.node.entries:
            name = entry.key.text
            if name in self._table.by_name:
                self._entries[name] = entry
        for entry in self.node.entries:
            if entry.key.text not in self._table.by_name:
                self._sort_stranger(entry)

    def _sort_stranger(self, entry: Entry) -> None:
        name = entry.key.text
        if name in self._table.misplaced:
            self.report.add(entry.key.place, *self._table.misplaced[name])
            return
        near = nearest(name, self._table.by_name)
        keys = listing(self._table.by_name, longest=20)
        all_keys = (
            f'the keys are {keys}' if len(self._table.keys) > 1 else f'the only key is {keys}'
        )
        hint = f'did you mean `{near}`?' if near else all_keys
        self.report.add(entry.key.place, f'{self._table.name} has no key {quoted(name)}', hint)
        if near is not None and near not in self._entries:
            self._read_as(near, entry)

    def _read_as(self, key: str, entry: Entry) -> None:
        """Take a misspelt key for the known one; not if its value is of another kind."""
        if _is_plausible(self._table.by_name[key].kind, entry.value):
            self._entries[key] = entry
        else:
            self._misread[key] = entry.value
        if key not in self._entries or entry.key.text in self.node.doubtful:
            self.doubt(key)

    def _report_missing(self) -> None:
        for key in self._table.keys:
            if key.required and key.name not in self._entries:
                is_explained = MERGE in self.node.doubtful or not self.is_sure(key.name)
                self.doubt(key.name)
                if not is_explained:
                    what = f'{self._table.name} needs the key `{key.name}`'
                    self.report.add(self.node.place, what, key.hint)

    def _default(self, key: str) -> object:
        return self._table.by_name[key].default

    def _whole(self, key: str) -> int | None:
        node = self.value(key)
        value = node.value if isinstance(node, Scalar) else None
        if isinstance(value, int) and not isinstance(value, bool):
            if self._is_in_range(key, value):
                return value
        elif node is not None:
            self._wrong_kind(key, node)
        return cast('int | None', self._default(key))

    def _number(self, key: str) -> float | None:
        node = self.value(key)
        value = node.value if isinstance(node, Scalar) else None
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            return float(value) if self._is_in_range(key, value) else None
        if node is not None:
            self._wrong_kind(key, node)
        return None

    def _is_in_range(self, key: str, value: float) -> bool:
        limit = broken_limit(self._table.by_name[key], value)
        if limit is None:
            return True
        what = sentence('key', key=key, needed=limit, given=found(self._entries[key].value))
        self.refuse(key, what, self._table.by_name[key].hint)
        return False

    def _wrong_kind(self, key: str, node: Node) -> None:
        wanted = self._table.by_name[key]
        kind = f'one of {listing(wanted.choices)}' if wanted.choices else wanted.kind.in_words
        self.refuse(key, sentence('key', key=key, needed=kind, given=found(node)), wanted.hint)


def fields_of(node: Node, table: Table, report: Report) -> Fields | None:
    """Return a cursor over a mapping; None if it is something else (reported)."""
    if isinstance(node, MapNode):
        return Fields(node, table, report)
    report.add(node.place, f'{table.name} must be a mapping, not {found(node)}', table.hint)
    return None


def file_fields(text: str, table: Table, report: Report) -> Fields:
    """Return a cursor over the mapping that is the text of a file.

    :raises Refused: it is no mapping, or no YAML, with what the report has; or it is another kind
        of file, which is not quoted
    """
    found_in_it = Report(report.file)
    root = compose(text, found_in_it)
    refuse_strangers(text, root, found_in_it, [table])
    report.take(found_in_it.findings)
    fields = fields_of(root, table, report) if root else None
    if fields is None:
        raise Refused(report.findings)
    return fields


def _is_plausible(kind: Kind, node: Node) -> bool:
    """Tell whether a value of this form can have been meant for a key of this kind."""
    if kind in (Kind.CONDITION, Kind.VALUE, Kind.SECTIONS, Kind.NAMES, Kind.SHARES):
        return True
    if kind in (Kind.TABLE, Kind.MAPPING):
        return isinstance(node, MapNode)
    return isinstance(node, ListNode if kind is Kind.LIST else Scalar)


def broken_limit(key: Key, value: float) -> str | None:
    """Say what a number must be, if it is not: at least 1."""
    low = -math.inf if key.minimum is None else key.minimum
    high = math.inf if key.maximum is None else key.maximum
    if not -math.inf < value < math.inf:
        return 'a finite number'
    if key.kind is Kind.TIMEOUT and value <= low:
        return f'greater than {low:g}'
    if value < low:
        return sentence('at_least', low=f'{low:g}')
    return sentence('at_most', high=f'{high:.0f}') if value > high else None
