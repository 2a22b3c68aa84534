"""Serials and lots in everything that is read from a journal."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
from fakes.line import expanded
from fakes.reading import TYPES, Reading

from bt_orchestrator.cli.main import main
from bt_orchestrator.extensions.page.web.archive.archive import Look
from bt_orchestrator.extensions.page.web.archive.ended_jobs import job_with_items
from bt_orchestrator.extensions.page.web.archive.histories import item_record, items_of
from bt_orchestrator.model.keeping.records import Wanted
from bt_orchestrator.script.script_file import parse_script
from bt_orchestrator.store.sqlite.records import SqliteRecords
from bt_orchestrator.store.sqlite.store import SqliteStore
from bt_orchestrator.view.report.csv_export import write_items
from bt_orchestrator.view.report.reading import Reading as JournalReading
from bt_orchestrator.view.report.xes_export import XesExport

SCRIPT = """
script: test
params: {glue: {type: str}}
lots: {glue: "${params.glue}"}
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2: [{id: read, @a2.RUN, identifies: code}]
  3: [{id: pack, @a3, qty_change: -1}]
"""


@pytest.fixture(scope='module')
def journal(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two jobs of two items each, with different glue."""
    reading = Reading()
    script = parse_script(expanded(SCRIPT), 'test.yaml', reading.cell, TYPES)
    reading.run.submit('J', script, 2, glue='L-1')
    reading.run.submit('K', script, 2, glue='L-2')
    assert reading.run.go().ended
    path = tmp_path_factory.mktemp('journal') / 'cell.sqlite3'
    with closing(SqliteStore(path)) as store:
        store.append(list(reading.run.store.read()))
    return path


@pytest.fixture
def look(journal: Path) -> Iterator[Look]:
    with closing(SqliteRecords(journal)) as records:
        yield Look(records, records.extent())


@pytest.mark.parametrize(
    ('options', 'items'),
    [
        (['--serial', 'S-3'], ['K/1']),
        (['--lot', 'glue=L-1'], ['J/1', 'J/2']),
        (['--lot', 'glue=L-2', '--serial', 'S-4'], ['K/2']),
        (['--lot', 'glue=L-2', '--job', 'K'], ['K/1', 'K/2']),
    ],
)
def test_history_finds_items(
    journal: Path, options: list[str], items: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    words = ['history', '--journal', str(journal), *options]
    assert main(words) == 0
    text = capsys.readouterr().out
    assert [name for name in ('J/1', 'J/2', 'K/1', 'K/2') if f'  {name}  ' in text] == items
    assert main([*words, '--json']) == 0
    jobs = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [item for job in jobs for item in job['items']] == items


def test_history_tells_what_it_found(journal: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(['history', '--journal', str(journal), '--serial', 'S-1']) == 0
    lines = capsys.readouterr().out.splitlines()
    assert '    serial: S-1' in lines
    assert '    lots: {"glue": "L-1"}' in lines


def test_history_of_what_is_not_there(journal: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ['history', '--journal', str(journal)]
    assert main([*words, '--serial', 'S-9']) == 1
    assert 'has no such item any more' in capsys.readouterr().err
    with pytest.raises(SystemExit):
        main([*words, '--lot', 'glue'])
    assert "a lot is NAME=LOT, found 'glue'" in capsys.readouterr().err


def test_job_response_has_lots_of_its_items(
    journal: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(['history', '--journal', str(journal), '--b2mml', '--job', 'J']) == 0
    (used,) = json.loads(capsys.readouterr().out)['JobResponse']['MaterialActual']
    assert (used['MaterialDefinitionID'], used['MaterialLotID']) == (['glue'], ['L-1'])
    (number,) = used['MaterialActualProperty']
    assert (used['MaterialUse'], number['Value'][0]['ValueString']) == ('Consumed', '2')


def test_a_table_of_items_has_columns_for_them(look: Look) -> None:
    file = io.StringIO(newline='')
    write_items(JournalReading(look.records).jobs().jobs['K'], file)
    rows = list(csv.DictReader(io.StringIO(file.getvalue(), newline='')))
    assert [(row['serial'], row['lots.glue']) for row in rows] == [('S-3', 'L-2'), ('S-4', 'L-2')]


def test_a_trace_has_them_as_attributes(look: Look) -> None:
    file = io.StringIO()
    export = XesExport(file)
    for record in JournalReading(look.records).each(Wanted()):
        export.write(record.text)
    export.close()
    assert file.getvalue().count('<string key="serial" value="S-1"/>') == 1
    assert file.getvalue().count('<string key="lot:glue" value="L-1"/>') == 2


def test_the_page_finds_an_item_by_its_serial(look: Look) -> None:
    (item,) = items_of(look, ' S-3 ')['items']
    assert (item['item'], item['job']) == ('K/1', 'K')
    assert items_of(look, 'S')['items'] == []


def test_page_shows_identity_of_item_and_job(look: Look) -> None:
    item, job = item_record(look, 'K/1'), job_with_items(look, 'K')
    assert item is not None
    assert job is not None
    for entry in (item, job['items'][0]):
        assert (entry['serial'], entry['lots']) == ('S-3', {'glue': 'L-2'})
