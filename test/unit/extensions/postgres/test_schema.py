"""The tables of a plant: each cell has its own, one writer has them, and views show all."""

from __future__ import annotations

from contextlib import closing

import pytest
from psycopg import errors

from bt_orchestrator.base.errors import DatabaseAway, JournalUnusable
from bt_orchestrator.extensions.postgres import schema
from bt_orchestrator.extensions.postgres.connecting import (
    Connection,
    Place,
    connected,
    place_of,
)
from bt_orchestrator.extensions.postgres.records import PostgresRecords
from bt_orchestrator.extensions.postgres.schema import (
    FEED,
    JOURNAL,
    Stretch,
    begin_stretch,
    cell_named,
    cells,
    check_of_event,
    enter,
    stretches,
)
from bt_orchestrator.extensions.postgres.views import VIEWS
from bt_orchestrator.model.keeping.books import ReasonPage


def write(connection: Connection, stretch: Stretch, seq: int, record: str = '{}') -> None:
    connection.execute(
        stretch.sql(
            'INSERT INTO {stretch}.events (seq, record, event, job, time) '
            "VALUES (%s, %s, 'job.started', 'J', 1.5)"
        ),
        (seq, record),
    )


def test_an_address_names_database_and_cell() -> None:
    place = place_of('postgresql://me:secret@db,db2:5433/plant/line%201?target_session_attrs=any')
    assert place.cell == 'line 1'
    assert place.address == 'postgresql://me:secret@db,db2:5433/plant?target_session_attrs=any'
    assert str(place) == 'postgresql://me@db,db2:5433/plant/line 1'
    assert place_of('postgresql:///plant').cell == ''


@pytest.mark.parametrize(
    'text', ['postgresql://db', 'postgresql://db/a/b/c', 'postgresql://h/d?x=1']
)
def test_a_wrong_address_is_refused(text: str) -> None:
    with pytest.raises(JournalUnusable, match='expected the address of a plant'):
        place_of(text)


def test_unreachable_server_is_named_without_password() -> None:
    with pytest.raises(DatabaseAway, match=r'postgresql://me@/plant/x cannot be reached') as error:
        connected(place_of('postgresql://me:secret@/plant/x?host=/nowhere'), 'test')
    assert 'secret' not in str(error.value)


def test_the_first_writer_makes_plant_and_cell(connection: Connection, place: Place) -> None:
    with pytest.raises(JournalUnusable, match='feed` makes the first one'):
        cells(connection)
    cell = enter(connection, 'line_1', FEED, 'me')
    stretch = begin_stretch(connection, cell, 'h1')
    assert (cell.epoch, stretch.tables, stretch.first_seq) == (1, f'cell_{cell.number}', 1)
    assert cell_named(connection, place).history == 'h1'
    with pytest.raises(JournalUnusable, match="found 'line_2'; it has: line_1"):
        cell_named(connection, place.of('line_2'))
    for view in VIEWS:
        assert connection.execute(f'SELECT * FROM plant.{view.name}'.encode()) is not None


def test_cell_has_one_writer_until_connection_ends(
    place: Place, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(schema, 'LOCK_TIMEOUT_S', 0.2)
    with connected(place, 'a') as first:
        enter(first, 'line_1', FEED, 'the first')
        with connected(place, 'b') as two:
            with pytest.raises(JournalUnusable, match='writes the cell line_1: the first since'):
                enter(two, 'line_1', FEED, 'the second')
            assert enter(two, 'line_2', FEED, 'the second').epoch == 1
    with connected(place, 'c') as three:
        assert enter(three, 'line_1', FEED, 'the third').epoch == 2


@pytest.mark.parametrize(
    ('first', 'second', 'words'),
    [(FEED, JOURNAL, 'no node may go on from it'), (JOURNAL, FEED, 'needs no feed')],
)
def test_a_copy_is_never_a_journal(
    connection: Connection, first: str, second: str, words: str
) -> None:
    enter(connection, 'line_1', first, 'me')
    with pytest.raises(JournalUnusable, match=words):
        enter(connection, 'line_1', second, 'me')


def test_views_show_all_stretches_of_all_cells(connection: Connection) -> None:
    cell = enter(connection, "o'ne", FEED, 'me')
    first = begin_stretch(connection, cell, 'h1')
    second = begin_stretch(connection, cell, 'h2', first, 3)
    other = begin_stretch(connection, enter(connection, 'two', FEED, 'me'), 'h3')
    for stretch, seq in ((first, 1), (first, 2), (second, 3), (other, 1)):
        write(connection, stretch, seq, '{"message": "\\u0000\\ud800 and \\\\u0000"}')
    query = b"SELECT cell, history, seq, fact ->> 'message' FROM plant.events ORDER BY 1, 3"
    rows = connection.execute(query).fetchall()
    assert [row[:3] for row in rows] == [
        *(("o'ne", 'h1', 1), ("o'ne", 'h1', 2), ("o'ne", 'h2', 3), ('two', 'h3', 1)),
    ]
    assert {str(row[3]) for row in rows} == {'�� and \\ufffd'}
    lineage = b'SELECT history, parent, first_seq, is_current FROM plant.histories ORDER BY 1'
    assert connection.execute(lineage).fetchall() == [
        *(('h1', None, 1, False), ('h2', 'h1', 3, True), ('h3', None, 1, True)),
    ]


def test_newer_tables_are_refused(connection: Connection) -> None:
    cell = enter(connection, 'line_1', FEED, 'me')
    begin_stretch(connection, cell, 'h1')
    connection.execute(b'UPDATE plant.stretches SET version = 99')
    with pytest.raises(JournalUnusable, match='have version 99, this program knows'):
        stretches(connection, cell)


def test_upgrade_gives_up_waiting_for_long_report(
    connection: Connection, place: Place, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A table that waits to be changed lets nobody else read or write it."""
    stretch = begin_stretch(connection, enter(connection, 'line_1', FEED, 'me'), 'h1')
    write(connection, stretch, 1)
    change = ('ALTER TABLE {stretch}.events ADD COLUMN more text',)
    monkeypatch.setattr(schema, '_STEPS', (*schema._STEPS, change))
    newer = schema.VERSION + 1
    monkeypatch.setattr(schema, 'VERSION', newer)
    monkeypatch.setattr(schema, 'LOCK_TIMEOUT_S', 0.2)
    with connected(place, 'report') as report, report.transaction():
        report.execute(b'SELECT count(*) FROM plant.events')
        with pytest.raises(JournalUnusable, match='while a long report reads them'):
            enter(connection, 'line_1', FEED, 'me')
        write(connection, stretch, 2)
    enter(connection, 'line_1', FEED, 'me')
    assert stretches(connection, cell_named(connection, place))[0].version == newer
    assert connection.execute(b'SELECT count(*) FROM plant.events').fetchone() == (2,)


def test_cells_of_two_versions_stand_in_one_plant(
    connection: Connection, place: Place, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A program brings the tables of its own cells up to date, and reads those of others."""
    with monkeypatch.context() as older:
        older.setattr(schema, '_STEPS', schema._STEPS[:1])
        older.setattr(schema, 'VERSION', 1)
        for number in (1, 2):
            begin_stretch(
                connection, enter(connection, f'line_{number}', FEED, 'me'), f'h{number}'
            )
    cell = enter(connection, 'line_1', FEED, 'me')
    assert [stretch.version for stretch in stretches(connection, cell)] == [schema.VERSION]
    begin_stretch(connection, enter(connection, 'line_3', FEED, 'me'), 'h3')
    with closing(PostgresRecords(place.of('line_2').whole)) as records:
        assert records.book_reasons() == ReasonPage((), (), None)
    rows = connection.execute(b'SELECT count(*) FROM plant.book_reasons').fetchone()
    assert rows == (0,)
    enter(connection, 'line_2', FEED, 'me')
    connection.execute(b'SELECT * FROM plant.book_reasons')


def test_a_reader_reads_everything_and_writes_nothing(
    connection: Connection, place: Place
) -> None:
    connection.execute(b'CREATE ROLE plant_reader')
    stretch = begin_stretch(connection, enter(connection, 'line_1', FEED, 'me'), 'h1')
    begin_stretch(connection, enter(connection, 'line_2', FEED, 'me'), 'h2')
    connection.execute(b'SET ROLE plant_reader')
    for view in VIEWS:
        connection.execute(f'SELECT * FROM plant.{view.name}'.encode())
    with pytest.raises(errors.InsufficientPrivilege):
        write(connection, stretch, 1)
    connection.execute(b'RESET ROLE')
    connection.execute(b'DROP OWNED BY plant_reader')
    connection.execute(b'DROP ROLE plant_reader')


def test_the_server_works_out_the_same_check(connection: Connection) -> None:
    enter(connection, 'line_1', FEED, 'me')
    query = b'SELECT plant.check_of_event(%s, %s, %s)'
    for row in ((1, '{}', 0), (1 << 40, 'Grüße ' * 500, 1), (7, '"\\ud800"', 0)):
        assert connection.execute(query, row).fetchone() == (check_of_event(*row),)
