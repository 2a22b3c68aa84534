"""Copies of whole journals, from a file into a database and back (semantics 9.2)."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
from contract.written_events import events
from postgres_server import PostgresServer

from bt_orchestrator.cli.main import main
from bt_orchestrator.extensions.postgres.connecting import connected, place_of
from bt_orchestrator.extensions.postgres.journal import PostgresStore
from bt_orchestrator.extensions.postgres.records import PostgresRecords
from bt_orchestrator.model.jobs.job_record import JobRecord
from bt_orchestrator.model.judging.used_ids import SealedIds, text_of
from bt_orchestrator.model.keeping.books import Books, KeptScript, KeptSlot, KeptState
from bt_orchestrator.model.keeping.records import Wanted
from bt_orchestrator.ports import Records, Snapshot
from bt_orchestrator.store.sqlite.records import SqliteRecords
from bt_orchestrator.store.sqlite.store import SqliteStore

PART = SealedIds(text_of(['A', 'Grüße'], {}))
LAST = 2500


@pytest.fixture(autouse=True)
def marks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('XDG_STATE_HOME', str(tmp_path / 'state'))
    monkeypatch.delenv('STATE_DIRECTORY', raising=False)


@pytest.fixture
def address(server: PostgresServer) -> str:
    return server.place(server.database(), 'line_1')


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """Give a journal with something in each table, and without its first events."""
    path = tmp_path / 'journal.db'
    with closing(SqliteStore(path, synchronous='NORMAL')) as store:
        for first in range(1, LAST, 500):
            store.append(events(first, first + 499))
        store.keep_used(PART)
        store.begin_with(Snapshot(99, 'program', '{"seq": 99}'))
        store.remove_batch(100)
        jobs = [JobRecord(f'J{n}', 's', 3, n / 3, status='completed') for n in range(7)]
        store.save(Snapshot(LAST, 'program', '{"ä": "\\u0000"}'), jobs)
        slots = [KeptSlot(10 * n, 10 * n + 10, 7, 1, f'{{"n": {n}}}') for n in range(5)]
        state = KeptState(LAST, 70, 9, True, 1, '{}')
        scripts = [KeptScript('digest', 'script: s')]
        store.keep_books(Books(store.history, LAST, True, slots, [state], scripts))
    return path


def told(records: Records) -> list[object]:
    """Return all that is in a journal, but its name."""
    contents: list[object] = []
    wanted, is_last = Wanted(), False
    while not is_last:
        page = records.page(wanted)
        assert not page.damage
        contents += page.records
        wanted, is_last = page.rest, page.is_last
    contents += [records.extent()[1:], records.state_before(LAST), records.state_before(LAST - 1)]
    contents += [records.summaries(), records.booked(0, 100), records.book_state(1 << 60)]
    return [*contents, records.book_script('digest')]


def test_9_2_copy_to_database_and_back_is_equal(
    file: Path, address: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    back = tmp_path / 'back.db'
    assert main(['journal', 'copy', str(file), address]) == 0
    assert f'compared: {LAST - 99} events (SHA-256 ' in capsys.readouterr().out
    assert main(['journal', 'copy', address, str(back)]) == 0
    with closing(SqliteRecords(file)) as records:
        before, history = told(records), records.extent().history
    with closing(PostgresRecords(address)) as between:
        assert told(between) == before
        assert between.extent().history != history
    with closing(SqliteRecords(back)) as after:
        assert told(after) == before


def test_9_2_copy_continues_as_restored_history(file: Path, address: str) -> None:
    assert main(['journal', 'copy', str(file), address]) == 0
    with closing(PostgresStore(address)) as store:
        assert store.is_restored
        assert store.missing(LAST) == ''
        assert store.used_ids(PART.digest) == PART.text
        assert store.first_needed((), 1) > LAST - 10
        store.append(events(LAST + 1, LAST + 3))
        assert list(store.read(LAST - 1)) == events(LAST, LAST + 3)


def test_9_2_a_journal_with_events_takes_no_copy(
    file: Path, address: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(['journal', 'copy', str(file), address]) == 0
    assert main(['journal', 'copy', str(file), address]) == 1
    assert 'name an empty one' in capsys.readouterr().err


def test_9_2_damaged_journal_is_not_copied(
    file: Path, address: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with closing(sqlite3.connect(file, isolation_level=None)) as database:
        database.execute("UPDATE events SET record = replace(record, '7', '8') WHERE seq = 700")
    assert main(['journal', 'copy', str(file), address]) == 1
    assert 'event 700 is damaged or missing' in capsys.readouterr().err
    with closing(PostgresStore(address)) as store:
        assert list(store.read()) == []


@pytest.mark.parametrize(
    ('table', 'words'),
    [
        ('events', 'the events that are read from the copy are not those written'),
        ('jobs', 'the table jobs of the copy is not what was written'),
    ],
)
def test_9_2_a_copy_that_differs_is_taken_back(
    file: Path, address: str, capsys: pytest.CaptureFixture[str], table: str, words: str
) -> None:
    """The database changes what it is given, as a trigger may."""
    PostgresStore(address).close()
    with connected(place_of(address), 'test', ['SET search_path = cell_1']) as connection:
        connection.execute(
            b'CREATE FUNCTION spoil() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN '
            b'IF random() < 2 THEN RETURN NULL; END IF; RETURN NEW; END $$'
        )
        connection.execute(
            f'CREATE TRIGGER spoil BEFORE INSERT ON {table} FOR EACH ROW '
            'EXECUTE FUNCTION spoil()'.encode()
        )
    assert main(['journal', 'copy', str(file), address]) == 1
    assert words in capsys.readouterr().err
    with closing(PostgresStore(address)) as store:
        assert (list(store.read()), store.is_restored) == ([], False)


def test_9_2_a_journal_in_use_is_not_copied(
    file: Path, address: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with closing(SqliteStore(file)):
        assert main(['journal', 'copy', str(file), address]) == 1
    assert 'in use by another orchestrator' in capsys.readouterr().err
    with closing(PostgresStore(address)):
        assert main(['journal', 'copy', str(file), address]) == 1
    assert 'in use by another orchestrator' in capsys.readouterr().err
