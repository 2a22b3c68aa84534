"""Whatever a ROS 2 message can carry is kept, and comes back as it was."""

from __future__ import annotations

import csv
import io
import json
import math
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from fakes.journal_reading import journal_reading

from bt_orchestrator.model import events as e
from bt_orchestrator.model.codec import to_text
from bt_orchestrator.model.keeping.records import Wanted
from bt_orchestrator.store.memory import MemoryStore
from bt_orchestrator.store.sqlite.store import SqliteStore
from bt_orchestrator.view.report.csv_export import CsvExport
from bt_orchestrator.view.report.xes_export import XesExport

VALUES: dict[str, Any] = {
    'nan': math.nan,
    'inf': math.inf,
    'minus_inf': -math.inf,
    'tiny': 5e-324,
    'huge': 1.7976931348623157e308,
    'float32': 3.4028234663852886e38,
    'minus_zero': -0.0,
    'int64': -(2**63),
    'uint64': 2**64 - 1,
    'bytes': [0, 255],
    'floats': [1.5, math.nan, math.inf],
    'nested': {'pose': {'x': math.nan, 'all': [{'y': -math.inf}]}},
    'empty': '',
    'large': 'x' * 1_000_000,
    'nul': 'a\0b',
    'surrogate': 'a\ud800b',
    'controls': '\x01\x1b[2J\x7f\ufffe\uffff',
    'quotes': '"\\\'</xml>]]>',
    'snowman': '☃𝄞',
    'looks_like_a_number': {'float': 'nan'},
}


def result(value: Any) -> e.TaskSucceeded:
    """Return an event that carries a value as the result of a task."""
    where: dict[str, Any] = {'job': 'WO-1', 'section': 1, 'item': 'WO-1/1', 'task': 'look'}
    return e.TaskSucceeded(
        seq=1, time=1.0, **where, attempt=1, goal='4f', results={'value': value}
    )


def reading(value: Any) -> e.ComponentStateChanged:
    """Return an event that carries a value of a state topic."""
    return e.ComponentStateChanged(seq=2, time=2.0, component='a', ready=False, value=value)


def started(value: Any) -> e.TaskStarted:
    """Return an event that carries a value as an argument."""
    where: dict[str, Any] = {'job': 'WO-1', 'section': 1, 'item': 'WO-1/2', 'task': 'look'}
    what: dict[str, Any] = {
        'name': 'LOOK',
        'action': '/a/do',
        'component': 'a',
        'args': {'value': value},
    }
    return e.TaskStarted(seq=3, time=3.0, **where, attempt=1, goal='50', **what)


@pytest.fixture(params=['memory', 'sqlite'])
def store(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[MemoryStore | SqliteStore]:
    if request.param == 'memory':
        yield MemoryStore()
        return
    opened = SqliteStore(tmp_path / 'journal.sqlite3')
    yield opened
    opened.close()


@pytest.mark.parametrize('name', VALUES)
def test_it_comes_back(store: MemoryStore | SqliteStore, name: str) -> None:
    value = VALUES[name]
    store.append([result(value), reading(value), started(value)])
    succeeded, changed, start = store.read()
    assert isinstance(succeeded, e.TaskSucceeded)
    assert isinstance(changed, e.ComponentStateChanged)
    assert isinstance(start, e.TaskStarted)
    for again in (succeeded.results['value'], changed.value, start.args['value']):
        assert repr(again) == repr(value)  # nan is not equal to itself, and 0.0 is to -0.0


@pytest.mark.parametrize('name', VALUES)
def test_its_record_is_strict_json(name: str) -> None:
    def refuse(constant: str) -> float:
        raise AssertionError(f'{constant} is no JSON')

    for event in (result(VALUES[name]), reading(VALUES[name]), started(VALUES[name])):
        text = to_text(event)
        json.loads(text, parse_constant=refuse)
        text.encode()


@pytest.mark.parametrize('name', VALUES)
def test_it_can_be_exported(tmp_path: Path, name: str) -> None:
    store = SqliteStore(tmp_path / 'journal.sqlite3')
    store.append([result(VALUES[name])])
    store.close()
    table, log = io.TextIOWrapper(io.BytesIO(), 'utf-8'), io.TextIOWrapper(io.BytesIO(), 'utf-8')
    exports = (CsvExport(table), XesExport(log))
    with journal_reading(tmp_path / 'journal.sqlite3') as journal:
        for _, text in journal.each(Wanted(job='WO-1')):
            for export in exports:
                export.write(text)
    for export in exports:
        export.close()
    table.seek(0)
    csv.field_size_limit(10_000_000)
    _, row = csv.reader(table)
    assert len(row) > 20
    log.seek(0)
    assert ET.fromstring(log.read()).find('{*}trace/{*}event') is not None
