"""From text to nodes, within limits, reporting what YAML itself forbids.

Built on the parser's events, not on PyYAML's composer: that one recurses without a limit, expands
aliases without a limit and knows nothing of duplicate keys.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import yaml

from bt_orchestrator.script.report import START, Place, Report
from bt_orchestrator.script.yaml_nodes import Entry, ListNode, MapNode, Node, Scalar, quoted

MOST_NODES = 200_000
"""Keys and values in one file, aliases counted as often as they are used."""

DEEPEST_NESTING = 40
"""Lists and mappings inside one another, through aliases too."""

MERGE = '<<'
"""Key that spreads another mapping; among `MapNode.doubtful` it stands for any unknown key."""

_HALF = re.compile('[\ud800-\udfff]')
_STANDARD = 'tag:yaml.org,2002:'
_TEXT_TAGS = {'!', *(_STANDARD + tag for tag in ('str', 'timestamp', 'binary'))}
_SCALAR_TAGS = _TEXT_TAGS | {_STANDARD + tag for tag in ('bool', 'int', 'float', 'null')}
_LIST_TAGS = {'!', _STANDARD + 'seq'}
_MAP_TAGS = {'!', _STANDARD + 'map'}


def compose(text: str, report: Report) -> Node | None:
    """Return the one document of a text; None if it cannot be read (reported)."""
    text = text.removeprefix('\ufeff')
    if not is_printable(text, report):
        return None
    try:
        return _Composer(_events(text, _fast_loader()), report).document()
    except yaml.YAMLError as fault:
        report_syntax(_clearest(text, fault), text, report)
    except _GiveUp as limit:
        report.add(limit.place, limit.what, limit.hint)
    return None


class _GiveUp(Exception):
    """Reading on makes no sense."""

    def __init__(self, place: Place, what: str, hint: str) -> None:
        self.place, self.what, self.hint = place, what, hint
        super().__init__(what)


@dataclass(frozen=True)
class _Part:
    """A composed node, with its expanded size and the depth below it."""

    node: Node
    size: int = 1
    height: int = 0


class _Composer:
    """Builds nodes from events; one per document."""

    def __init__(self, events: Iterator[Any], report: Report) -> None:
        self._events = events
        self._report = report
        self._anchors: dict[str, _Part | None] = {}

    def document(self) -> Node | None:
        """Return the root of the only document."""
        next(self._events)
        if isinstance(next(self._events), yaml.StreamEndEvent):
            self._report.add(START, 'the file is empty', 'see the examples for what belongs here')
            return None
        root = self._part(next(self._events), 0).node
        next(self._events)
        extra = next(self._events)
        if not isinstance(extra, yaml.StreamEndEvent):
            raise _GiveUp(
                _place(extra), 'a second document begins here', 'keep one document in a file'
            )
        return root

    def _part(self, event: Any, depth: int) -> _Part:
        if isinstance(event, yaml.AliasEvent):
            return self._limited(self._alias(event), event, depth)
        if event.anchor is not None:
            self._anchors[event.anchor] = None
        part = self._limited(self._new_part(event, depth), event, depth)
        if event.anchor is not None:
            self._anchors[event.anchor] = part
        return part

    def _new_part(self, event: Any, depth: int) -> _Part:
        if depth > DEEPEST_NESTING:
            raise _too_deep(_place(event))
        if isinstance(event, yaml.ScalarEvent):
            self._check_tag(event, _SCALAR_TAGS)
            self._check_escapes(event)
            return _Part(Scalar(_place(event), event.value, _is_text(event)))
        if isinstance(event, yaml.SequenceStartEvent):
            self._check_tag(event, _LIST_TAGS)
            return self._sequence(event, depth)
        self._check_tag(event, _MAP_TAGS)
        return self._mapping(event, depth)

    def _alias(self, event: Any) -> _Part:
        name = event.anchor
        part = self._anchors.get(name)
        if part is not None:
            return part
        if name in self._anchors:
            what, hint = f'`*{name}` refers to itself', 'write the value out'
        else:
            what, hint = f'`*{name}` refers to nothing', f'define `&{name}` before it is used'
        raise _GiveUp(_place(event), what, hint)

    def _limited(self, part: _Part, event: Any, depth: int) -> _Part:
        if part.size > MOST_NODES:
            what = f'the file has more than {MOST_NODES} keys and values, aliases counted'
            raise _GiveUp(_place(event), what, 'split the file, or use fewer aliases')
        if depth + part.height > DEEPEST_NESTING:
            raise _too_deep(_place(event))
        return part

    def _check_tag(self, event: Any, allowed: set[str]) -> None:
        if event.tag is not None and event.tag not in allowed:
            tag = event.tag.replace(_STANDARD, '!!')
            self._report.add(
                _place(event), f'the tag {quoted(tag)} is not allowed here', 'remove the tag'
            )

    def _check_escapes(self, event: Any) -> None:
        """Report an escaped half of a character: no text that contains one can be written."""
        if _HALF.search(event.value):
            what = 'this text contains half of a surrogate pair'
            self._report.add(_place(event), what, 'write the character itself')

    def _sequence(self, start: Any, depth: int) -> _Part:
        parts: list[_Part] = []
        size = 1
        while not isinstance(event := next(self._events), yaml.SequenceEndEvent):
            parts.append(self._part(event, depth + 1))
            size = self._grown(size, parts[-1], event)
        return _Part(ListNode(_place(start), tuple(p.node for p in parts)), size, _height(parts))

    def _mapping(self, start: Any, depth: int) -> _Part:
        entries = _Entries(self._report)
        parts: list[_Part] = []
        size = 1
        while not isinstance(event := next(self._events), yaml.MappingEndEvent):
            key = self._part(event, depth + 1)
            value = self._part(next(self._events), depth + 1)
            entries.add(key.node, value.node)
            parts += (key, value)
            size = self._grown(self._grown(size, key, event), value, event)
        return _Part(entries.node(_place(start)), size, _height(parts))

    def _grown(self, size: int, part: _Part, event: Any) -> int:
        """Add a part's size; stops early, before anything grows beyond the limit."""
        return self._limited(_Part(part.node, size + part.size), event, 0).size


class _Entries:
    """The entries of one mapping: duplicate keys reported, merges spread."""

    def __init__(self, report: Report) -> None:
        self._report = report
        self._entries: dict[str, Entry] = {}
        self._merged: list[Entry] = []
        self._doubtful: set[str] = set()
        self._repeated: list[Entry] = []
        self._lost: list[Node] = []

    def add(self, key: Node, value: Node) -> None:
        """Add a key and its value."""
        if not isinstance(key, Scalar):
            self._drop(MERGE, key.place, 'a key must be a plain name', 'write `name: value`')
            self._lost += (key, value)
        elif key.text == MERGE and not key.is_text:
            self._merge(key, value)
        elif key.text in self._entries:
            line = self._entries[key.text].key.place.line
            self._drop(
                key.text,
                key.place,
                f'the key {quoted(key.text)} is given twice',
                f'keep one; the first is in line {line}',
            )
            self._repeated.append(Entry(key, value))
        else:
            self._entries[key.text] = Entry(key, value)

    def node(self, place: Place) -> MapNode:
        """Return the mapping; a key's own value goes before a merged one."""
        for entry in self._merged:
            self._entries.setdefault(entry.key.text, entry)
        return MapNode(
            place,
            tuple(self._entries.values()),
            frozenset(self._doubtful),
            tuple(self._repeated),
            tuple(self._lost),
        )

    def _merge(self, key: Scalar, value: Node) -> None:
        for source in value.items if isinstance(value, ListNode) else (value,):
            if not isinstance(source, MapNode):
                self._drop(MERGE, key.place, 'only mappings can be merged', 'write `<<: *name`')
                self._lost.append(value)
                return
            self._merged.extend(source.entries)

    def _drop(self, key: str, place: Place, what: str, hint: str) -> None:
        self._doubtful.add(key)
        self._report.add(place, what, hint)


def _too_deep(place: Place) -> _GiveUp:
    what = f'lists and mappings are nested deeper than {DEEPEST_NESTING}'
    return _GiveUp(place, what, 'nothing in these files needs that depth; flatten it')


def _height(parts: list[_Part]) -> int:
    return 1 + max((part.height for part in parts), default=0)


def _is_text(event: Any) -> bool:
    """Tell whether a scalar is text whatever it looks like: quoted, or tagged so."""
    if event.tag in _SCALAR_TAGS:
        return event.tag in _TEXT_TAGS
    return not event.implicit[0]


def _place(event: Any) -> Place:
    return Place(event.start_mark.line + 1, event.start_mark.column + 1)


def _fast_loader() -> Any:
    """Return libyaml's parser where PyYAML was built with it; it is ten times faster."""
    return getattr(yaml, 'CSafeLoader', yaml.SafeLoader)


def _events(text: str, loader: Any) -> Iterator[Any]:
    return iter(yaml.parse(text, Loader=loader))


def _clearest(text: str, fault: yaml.YAMLError) -> yaml.YAMLError:
    """Return the fault as the Python parser words it: it names places and tokens better."""
    try:
        _Composer(_events(text, yaml.SafeLoader), Report('')).document()
    except yaml.YAMLError as clearer:
        return clearer
    except _GiveUp:
        pass
    return fault


# Saying what is wrong with a text that is not YAML.

_CONTROL = re.compile('[^\t\n\r\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]')

_SYNTAX_HINTS = (
    ("'\\t'", 'indent with spaces: YAML allows no tabs there'),
    ('mapping values', 'check the indentation; text that contains `: ` needs quotes'),
    ('end of stream', 'a quote or bracket is opened and never closed'),
    ('<stream end>', 'a quote or bracket is opened and never closed'),
    ("expected ',' or", 'a bracket is not closed, or a comma is missing'),
    ("could not find expected ':'", 'a key needs a colon and a space after it'),
    ('that cannot start any token', 'put the text in quotes'),
    ('expected <block end>', 'lines of one list or mapping must begin in the same column'),
)


def report_syntax(fault: yaml.YAMLError, text: str, report: Report) -> None:
    """Report what the parser stumbled over in a text, with a hint at the usual cause."""
    mark = getattr(fault, 'problem_mark', None) or getattr(fault, 'context_mark', None)
    place = Place(mark.line + 1, mark.column + 1) if mark else START
    problem = ' '.join(str(getattr(fault, 'problem', None) or fault).split())
    hints = (hint for fragment, hint in _SYNTAX_HINTS if fragment in problem)
    hint = next(hints, 'check brackets, quotes and indentation up to here')
    if mark and text[: mark.index].endswith('$') and text.startswith('{', mark.index):
        hint = 'put a reference in quotes: "${...}"'
    report.add(place, f'this is not YAML: {problem}', hint)


def is_printable(text: str, report: Report) -> bool:
    """Tell whether YAML allows every character of a text; report the first that it forbids."""
    control = _CONTROL.search(text)
    if control is None:
        return True
    before = text[: control.start()]
    line = before.count('\n') + 1
    column = control.start() - (before.rfind('\n') + 1) + 1
    what = f'the character U+{ord(control.group()):04X} is not allowed in a text file'
    report.add(Place(line, column), what, 'remove it, or save the file as plain text')
    return False
