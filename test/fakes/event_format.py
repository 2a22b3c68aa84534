"""The events as docs/formats.md describes them, and whether a record is one."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from typing import Any

from fakes.shipped import ROOT

OF_EVERY_RECORD = frozenset({'seq', 'time', 'event'})
ORDER = ('seq', 'time', 'event', 'job', 'section', 'item', 'task')


@cache
def documented() -> Mapping[str, Mapping[str, bool]]:
    """Return the fields of each event on the page; true: must be there."""
    text = (ROOT / 'docs' / 'formats.md').read_text(encoding='utf-8')
    table = text.partition('<!-- generated: events -->')[2].partition('<!-- end -->')[0]
    rows = re.findall(r'^\| `([a-z_]+\.[a-z_]+)` \| .*? \| (.*) \|$', table, re.MULTILINE)
    fields = r'`(\w+)(\??)`(?=,|<br>|:|$)'
    return {
        name: {field: not optional for field, optional in re.findall(fields, listed)}
        for name, listed in rows
    }


def mistake_in(record: Mapping[str, Any]) -> str | None:
    """Say how a record differs from the page; None: it is as documented."""
    fields = documented().get(record['event'])
    if fields is None:
        return f'{record["event"]} is not documented'
    unknown = set(record) - set(fields) - OF_EVERY_RECORD
    missing = {name for name, needed in fields.items() if needed} - set(record)
    empty = {name for name, value in record.items() if value is None}
    named = [name for name in record if name in ORDER]
    disorder = [] if named == sorted(named, key=ORDER.index) else named
    if unknown or missing or empty or disorder:
        return f'unknown {unknown}, missing {missing}, empty {empty}, disorder {disorder}'
    return None
