"""The content of a YAML text, with places: three kinds of nodes, and the plain value of a scalar.

Nothing is constructed while reading, so an id such as 4.10 keeps its text (formats: script), and
no text can name a Python object.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

from bt_orchestrator.model.words import sentence
from bt_orchestrator.script.report import START, Place

Value = bool | int | float | str | None

LONGEST_NUMBER = 400
"""Digits; a longer row of digits is text (Python refuses to convert very long ones)."""

_WORDS: Mapping[str, Value] = {
    '': None, '~': None, 'null': None, 'Null': None, 'NULL': None,
    'true': True, 'True': True, 'TRUE': True,
    'false': False, 'False': False, 'FALSE': False,
}  # fmt: skip
_WHOLE = re.compile(r'[-+]?(?:0|[1-9][0-9]*)')
_BASED = re.compile(r'0x[0-9a-fA-F]+|0o[0-7]+')
_REAL = re.compile(
    r'[-+]?(?:(?:\.[0-9]+|[0-9]+\.[0-9]*)(?:[eE][-+]?[0-9]+)?|[0-9]+[eE][-+]?[0-9]+)'
)
_SPECIAL = re.compile(r'[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN)')


@dataclass(frozen=True)
class Scalar:
    """A single value, as written."""

    place: Place
    text: str
    is_text: bool
    """True for a quoted or block scalar: text, whatever it looks like."""

    @cached_property
    def value(self) -> Value:
        """The plain value: YAML 1.2's core rules, so `no` and `on` are text, `010` is too."""
        return self.text if self.is_text else plain_value(self.text)


@dataclass(frozen=True)
class ListNode:
    """A sequence."""

    place: Place
    items: tuple[Node, ...]


@dataclass(frozen=True)
class Entry:
    """One key of a mapping with its value."""

    key: Scalar
    value: Node


@dataclass(frozen=True)
class MapNode:
    """A mapping; of a key that was written twice only the first value is kept."""

    place: Place
    entries: tuple[Entry, ...]
    doubtful: frozenset[str] = frozenset()
    """Keys with parts that were left out (and reported)."""
    repeated: tuple[Entry, ...] = ()
    """Keys that were written before, with their further values (reported)."""
    lost: tuple[Node, ...] = ()
    """Values that belong to no key (reported)."""

    @property
    def is_complete(self) -> bool:
        """Tell whether nothing had to be left out."""
        return not self.doubtful

    def joined(self, other: MapNode) -> MapNode:
        """Return this mapping with the entries of another one, its own first."""
        known = {entry.key.text for entry in self.entries}
        new = tuple(entry for entry in other.entries if entry.key.text not in known)
        again = tuple(entry for entry in other.entries if entry.key.text in known)
        return MapNode(
            self.place,
            self.entries + new,
            self.doubtful | other.doubtful | {entry.key.text for entry in again},
            self.repeated + other.repeated + again,
            self.lost + other.lost,
        )

    def find(self, key: str) -> Entry | None:
        """Return the entry of a key."""
        return next((entry for entry in self.entries if entry.key.text == key), None)


Node = Scalar | ListNode | MapNode


def place_of_key(node: Node | None, *path: str) -> Place:
    """Return the place of a key, named by the keys around it; of the last one that is there."""
    place = START
    for key in path:
        entry = node.find(key) if isinstance(node, MapNode) else None
        if entry is None:
            return place
        place, node = entry.key.place, entry.value
    return place


def as_data(node: Node) -> object:
    """Return plain data, without places."""
    if isinstance(node, Scalar):
        return node.value
    if isinstance(node, ListNode):
        return [as_data(item) for item in node.items]
    return {entry.key.text: as_data(entry.value) for entry in node.entries}


def words(node: Node) -> Iterator[str]:
    """Yield every text in a node, keys too."""
    if isinstance(node, Scalar):
        yield node.text
    elif isinstance(node, ListNode):
        for item in node.items:
            yield from words(item)
    else:
        for entry in (*node.entries, *node.repeated):
            yield entry.key.text
            yield from words(entry.value)
        for value in node.lost:
            yield from words(value)


def plain_value(text: str) -> Value:
    """Return what an unquoted scalar means."""
    if text in _WORDS:
        return _WORDS[text]
    if len(text) > LONGEST_NUMBER:
        return text
    if _WHOLE.fullmatch(text):
        return int(text)
    if _BASED.fullmatch(text):
        return int(text, 0)
    if _REAL.fullmatch(text):
        return float(text)
    if _SPECIAL.fullmatch(text):
        return float(text.replace('.', ''))
    return text


def found(node: Node) -> str:
    """Name what was written, for a message: text `abc`, the number 3, a list."""
    if isinstance(node, ListNode):
        return 'a list'
    if isinstance(node, MapNode):
        return 'a mapping'
    return found_value(node.value)


def found_value(value: object) -> str:
    """Name a plain value, for a message."""
    if value is None:
        return sentence('given_nothing')
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (int, float)):
        return sentence('given_number', number=shortened(str(value)))
    if isinstance(value, str):
        return sentence('given_text', text=quoted(value)) if value else 'empty text'
    return 'a mapping' if isinstance(value, Mapping) else 'a list'


def quoted(text: str) -> str:
    """Put a user's text into a message: in backticks, printable, one line, not too long."""
    return f'`{shortened(text)}`'


def shortened(text: str, longest: int = 60) -> str:
    """Make a user's text printable, one line and not too long."""
    printable = ''.join(
        char if char.isprintable() else char.encode('unicode_escape', 'replace').decode()
        for char in text[: longest + 1]
    )
    return printable if len(printable) <= longest else printable[: longest - 3] + '...'
