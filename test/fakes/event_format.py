"""The events as docs/events.md describes them, and whether a record is one."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from functools import cache
from typing import Any, NamedTuple

from fakes.shipped import ROOT

ORDER = ('seq', 'time', 'event', 'job', 'section', 'item', 'task')

KINDS: Mapping[str, Callable[[Any], bool]] = {
    '': lambda value: type(value) is str,
    'true or false': lambda value: type(value) is bool,
    'whole number': lambda value: type(value) is int,
    'number': lambda value: type(value) in (int, float),
    'list of text': lambda value: type(value) is list and all(type(m) is str for m in value),
    'object': lambda value: type(value) is dict and all(type(key) is str for key in value),
    'any value': lambda value: type(value) in (str, bool, int, float, list, dict),
}


class Field(NamedTuple):
    """What the page says of a field."""

    needed: bool
    kind: str


OF_EVERY_RECORD = {
    'seq': Field(True, 'whole number'),
    'time': Field(True, 'number'),
    'event': Field(True, ''),
}


@cache
def documented() -> Mapping[str, Mapping[str, Field]]:
    """Return the fields of each event on the page."""
    text = (ROOT / 'docs' / 'events.md').read_text(encoding='utf-8')
    table = text.partition('<!-- generated: events -->')[2].partition('<!-- end -->')[0]
    row = r'^\| `([a-z_]+\.[a-z_]+)` \| .*? \| (.*) \|$'
    place = r'^\| `(\w+)`(?: \(([\w ]+)\))? \|'
    field = r'(?:^|<br>|, )`(\w+)(\??)`(?: \(([\w ]+)\))?(?=, `|<br>|:|$)'
    kinds = dict(re.findall(place, table, re.MULTILINE))
    return {
        name: OF_EVERY_RECORD
        | {
            name: Field(not optional, kind or kinds.get(name, ''))
            for name, optional, kind in re.findall(field, fields)
        }
        for name, fields in re.findall(row, table, re.MULTILINE)
    }


def mistake_in(record: Mapping[str, Any]) -> str | None:
    """Say how a record differs from the page; None: it is as documented."""
    fields = documented().get(record['event'])
    if fields is None:
        return f'{record["event"]} is not documented'
    unknown = set(record) - set(fields)
    missing = {name for name, field in fields.items() if field.needed} - set(record)
    others = {name for name in set(record) & set(fields) if not _fits(record[name], fields[name])}
    named = [name for name in record if name in ORDER]
    disorder = [] if named == sorted(named, key=ORDER.index) else named
    if unknown or missing or others or disorder:
        return f'unknown {unknown}, missing {missing}, of other kinds {others}, order {disorder}'
    return None


def _fits(value: Any, field: Field) -> bool:
    return KINDS[field.kind](value)
