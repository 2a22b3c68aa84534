"""The keys of cell files, scripts and work orders."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path

from bt_orchestrator.script.keys import LARGEST_WHOLE, LONGEST_SECONDS, Key, Kind, Table
from tables.markdown import cell, code, table

_RULES = Path(__file__).resolve().parents[1] / 'semantics.md'


def keys_of(root: Table) -> Iterator[str]:
    """Yield a table for every kind of mapping that can be met below a root."""
    for one in {one.name: one for one in root.tree()}.values():
        yield f'**{one.name[0].upper()}{one.name[1:]}**'
        yield ''
        yield from keys_in(one)


def keys_in(mapping: Table) -> Iterator[str]:
    """Yield the keys of one kind of mapping."""
    yield from table(
        ('key', 'value', 'meaning', 'example', 'rule'),
        (
            (f'`{key.name}`', _value(key), _meaning(key), code(key.example), _rule(key))
            for key in mapping.keys
        ),
    )


def _rule(key: Key) -> str:
    """Return a link to the rule; keys that only generated scripts need have none."""
    if not key.rule:
        return ''
    return f'[{key.rule}](semantics.md#{_chapters()[key.rule.partition(".")[0]]})'


@cache
def _chapters() -> Mapping[str, str]:
    """Return what links call the chapters of the rules, by their numbers."""
    headings = re.findall(r'^## ((\d)\. .*)$', _RULES.read_text(encoding='utf-8'), re.MULTILINE)
    return {
        number: re.sub(r'[^\w -]', '', heading.lower()).replace(' ', '-')
        for heading, number in headings
    }


def _value(key: Key) -> str:
    if key.choices:
        return ', '.join(f'`{choice}`' for choice in key.choices)
    return key.kind.in_words


def _meaning(key: Key) -> str:
    notes = [key.meaning]
    if key.required:
        notes.append('**required**')
    if key.default is not None:
        notes.append(f'default `{_plain(key.default)}`')
    if key.minimum is not None and key.kind in (Kind.WHOLE, Kind.SECONDS, Kind.TIMEOUT):
        notes.append(_range(key))
    return cell('; '.join(notes))


def _range(key: Key) -> str:
    low = f'more than {key.minimum:g}' if key.kind is Kind.TIMEOUT else f'{key.minimum:g}'
    if key.maximum in (None, LARGEST_WHOLE, LONGEST_SECONDS):
        return low if key.kind is Kind.TIMEOUT else f'at least {low}'
    return f'{low} to {key.maximum:g}'


def _plain(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)
