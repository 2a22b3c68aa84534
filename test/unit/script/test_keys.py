"""The tables of keys agree with themselves: what they say is what the reader takes."""

from __future__ import annotations

import pytest
from fakes.script_texts import mistakes

from bt_orchestrator.script.composing import compose
from bt_orchestrator.script.fields import Fields
from bt_orchestrator.script.json_schema import SCHEMA_FILES
from bt_orchestrator.script.keys import Key, Kind, Table
from bt_orchestrator.script.report import Report
from bt_orchestrator.script.yaml_nodes import MapNode

TABLES = {table.name: table for root in SCHEMA_FILES.values() for table in root.tree()}
KEYS = [
    pytest.param(table, key, id=f'{name}: {key.name}')
    for name, table in TABLES.items()
    for key in table.keys
]

READERS = {
    Kind.TEXT: Fields.text,
    Kind.WHOLE: Fields.optional_whole,
    Kind.SECONDS: Fields.seconds,
    Kind.SWITCH: Fields.switch,
    Kind.CHOICE: Fields.choice,
    Kind.LIST: Fields.items,
    Kind.MAPPING: Fields.mapping,
    Kind.TABLE: Fields.mapping,
    Kind.INSTANT: Fields.text,
    Kind.SECTIONS: Fields.value,
    Kind.NAMES: Fields.names,
    Kind.VALUE: Fields.value,
    Kind.REFERENCE: Fields.value,
    Kind.BOUND: Fields.value,
    Kind.CONDITION: Fields.value,
    Kind.SHARE: Fields.share,
    Kind.SHARES: Fields.share,
}


def read(table: Table, key: Key, value: str) -> object:
    report = Report('file.yaml')
    node = compose(f'{key.name}: {value}', report)
    assert isinstance(node, MapNode)
    optional = Table(table.name, tuple(k for k in table.keys if k is key), table.misplaced)
    fields = Fields(node, optional, report)
    got = (
        fields.timeout(key.name, 0.0)
        if key.kind is Kind.TIMEOUT
        else READERS[key.kind](fields, key.name)
    )
    report.refuse()
    return got


def test_there_are_all_tables() -> None:
    assert len(TABLES) == 33


@pytest.mark.parametrize(('table', 'key'), KEYS)
def test_the_example_of_every_key_is_right(table: Table, key: Key) -> None:
    assert mistakes(lambda: read(table, key, key.example)) == []
    assert read(table, key, key.example) not in (None, '', ())


@pytest.mark.parametrize(('table', 'key'), KEYS)
def test_every_key_says_what_it_means(table: Table, key: Key) -> None:
    assert key.meaning
    assert bool(key.choices) is (key.kind is Kind.CHOICE)
    assert not (key.required and key.default is not None)
    assert key.name not in table.misplaced


@pytest.mark.parametrize(('table', 'key'), KEYS)
def test_a_default_is_in_range(table: Table, key: Key) -> None:
    if key.default is not None:
        text = str(key.default).lower() if isinstance(key.default, bool) else str(key.default)
        assert read(table, key, text) == key.default


@pytest.mark.parametrize(('table', 'key'), KEYS)
@pytest.mark.parametrize('value', ['{a: 1}', '[1]', 'word', '-1000000000000', '.nan', 'null', ''])
def test_no_value_is_worse_than_a_finding(table: Table, key: Key, value: str) -> None:
    findings = mistakes(lambda: read(table, key, value))
    assert len(findings) <= 1
    assert all(f'`{key.name}`' in finding for finding in findings)


def test_names_are_unique() -> None:
    for table in TABLES.values():
        assert len(table.by_name) == len(table.keys)
