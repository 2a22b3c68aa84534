"""docs/plant.md: its statements set up a database, and its queries say what happened."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import psycopg
import pytest
from fakes.kept_books import book_all
from fakes.line import Line
from fakes.long_journal import LongRun
from postgres_server import PostgresServer

from bt_orchestrator.extensions.postgres.connecting import Connection, connected, place_of
from bt_orchestrator.extensions.postgres.feed import Feed
from bt_orchestrator.extensions.postgres.schema import FEED, enter
from bt_orchestrator.extensions.postgres.sources import FileSource

ROOT = Path(__file__).parents[4]
PAGE = (ROOT / 'docs' / 'plant.md').read_text()
DASHBOARD = json.loads((ROOT / 'config' / 'plant_dashboard.json').read_text())
SET_UP, *QUERIES = re.findall(r'```sql\n(.*?)```', PAGE, flags=re.DOTALL)


@pytest.fixture(scope='module')
def feeder(server: PostgresServer, tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Set the database up as the page says, and feed it; gives the address for readers."""
    with psycopg.connect(server.address('postgres'), autocommit=True) as connection:
        for statement in SET_UP.split(';')[:-1]:
            connection.execute(statement.encode())
    path = tmp_path_factory.mktemp('cell') / 'journal.sqlite3'
    run = LongRun(path, Line(faults={'b2': '#1=abort'}))
    run.job('J1', 3, RETRIED)
    book_all(run.store, path)
    run.close()
    address = server.address('plant').replace('plant@', 'plant_feed@')
    with connected(place_of(address), 'test') as connection, closing(FileSource(path)) as source:
        feed = Feed(connection, enter(connection, 'line_1', FEED, 'a test'))
        done = feed.copy_events(source)
        feed.copy_tables(path, done)
        feed.is_complete()
        # In virtual time it was 1970: bring it near.
        connection.execute(
            b'UPDATE cell_1.events SET time = time + extract(epoch FROM now()) - 3600'
        )
        connection.execute(
            b'UPDATE cell_1.book_slots SET until_us = until_us + 1e6 * extract(epoch FROM now()), '
            b"slot = regexp_replace(slot, '}$', %s)",
            (', "stops": [{"loss": "own_fault", "us": 120000000}]}',),
        )
        connection.execute(
            b'UPDATE cell_1.jobs SET summary = regexp_replace(summary, \'"ended": [0-9.]+\', '
            b'\'"ended": \' || extract(epoch FROM now()))'
        )
        add_serial(connection)
    yield server.address('plant').replace('plant@', 'plant_reader@')
    with psycopg.connect(server.address('postgres'), autocommit=True) as connection:
        connection.execute(b'DROP DATABASE plant WITH (FORCE)')
        connection.execute(b'DROP ROLE plant_feed, plant_reader')


def add_serial(connection: Connection) -> None:
    record = '{"event": "item.identified", "item": "J1/2", "serial": "SERIAL"}'
    connection.execute(
        'INSERT INTO cell_1.events (seq, record, event, job, time) '
        "VALUES (9999, %s, 'item.identified', 'J1', extract(epoch FROM now()))",
        (record,),
    )


RETRIED = """
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2: [{id: work, @b2, retries: 1}]
  3: [{id: pack, @a3, qty_change: -1}]
"""


def asked(address: str, query: str) -> list[dict[str, object]]:
    with psycopg.connect(address, row_factory=psycopg.rows.dict_row) as connection:
        rows: list[dict[str, object]] = connection.execute(query.encode()).fetchall()
        return rows


def test_the_queries_say_what_happened(feeder: str) -> None:
    stands, made, lost, failed, serial = (asked(feeder, query) for query in QUERIES)
    assert [(row['cell'], row['state']) for row in stands] == [('line_1', 'Complete')]
    assert [(row['jobs'], row['good'], row['rejected']) for row in made] == [(1, 3, 0)]
    assert [(row['loss'], float(str(row['minutes']))) for row in lost] == [('own_fault', 2.0)]
    assert [(row['task'], row['reason'], row['failed']) for row in failed] == [
        ('work', 'aborted', 1)
    ]
    assert [(row['cell'], row['item']) for row in serial] == [('line_1', 'J1/2')]


def test_a_reader_has_little_time_and_writes_nothing(feeder: str) -> None:
    assert asked(feeder, 'SHOW statement_timeout') == [{'statement_timeout': '30s'}]
    with pytest.raises(psycopg.errors.ReadOnlySqlTransaction):
        asked(feeder, "INSERT INTO plant.cells (cell, kept_by) VALUES ('x', 'feed')")


def test_the_dashboard_has_the_queries_of_the_page() -> None:
    panels = DASHBOARD['panels']
    titles = re.findall(r'^### (.*)\n\n```sql', PAGE, flags=re.MULTILINE)
    assert [panel['title'] for panel in panels] == titles
    targets = [panel['targets'][0] for panel in panels]
    texts = [target['rawSql'].replace('${serial}', 'SERIAL') for target in targets]
    assert texts == [query.rstrip().removesuffix(';') for query in QUERIES]
    assert {target['datasource']['uid'] for target in targets} == {'${DS_PLANT}'}
    assert [panel['id'] for panel in panels] == list(range(1, len(panels) + 1))
    tops = [panel['gridPos']['y'] for panel in panels]
    assert tops == sorted(set(tops))
