"""The contract of readers, on the copy of a journal that a feed makes."""

from __future__ import annotations

import io
import shutil
import sqlite3
from collections.abc import Sequence
from contextlib import closing, redirect_stdout
from pathlib import Path

import pytest
from contract.kept_tables import DamagedTables
from contract.records_contract import Kept, KeptRecordsContract
from contract.written_events import events
from postgres_server import PostgresServer

from bt_orchestrator.base.errors import JournalUnusable
from bt_orchestrator.cli.main import main
from bt_orchestrator.extensions.postgres.connecting import connected, place_of
from bt_orchestrator.extensions.postgres.records import PostgresRecords
from bt_orchestrator.model.events import Event, OrchestratorStarted
from bt_orchestrator.model.jobs.job_record import JobRecord
from bt_orchestrator.model.keeping.books import Books, KeptScript, KeptSlot, KeptState
from bt_orchestrator.model.keeping.records import Wanted
from bt_orchestrator.ports import Records, Snapshot
from bt_orchestrator.store.sqlite.restoring import bring_back
from bt_orchestrator.store.sqlite.store import SqliteStore


class _Copied(DamagedTables):
    """A journal file; before anybody reads, a feed copies what is new in it."""

    def __init__(self, address: str, folder: Path) -> None:
        self._address, self.path = address, folder / 'journal.sqlite3'
        self._store = SqliteStore(self.path, synchronous='NORMAL')
        self._is_new = True
        self._records: PostgresRecords | None = None

    @property
    def records(self) -> Records:
        if self._is_new:
            with redirect_stdout(io.StringIO()):
                main(['feed', '--journal', str(self.path), '--to', self._address])
            self._is_new = False
        if self._records is None:
            self._records = PostgresRecords(self._address)
        return self._records

    def append(self, events: Sequence[Event]) -> None:
        self._store.append(events)
        self._is_new = True

    def save(self, ended: Sequence[JobRecord]) -> None:
        last = max((event.seq for event in self._store.read()), default=0)
        self._store.save(Snapshot(last, 'stamp', '{}'), ended)
        self._is_new = True

    def remove(self, before: int) -> None:
        self._store.begin_with(Snapshot(before - 1, 'stamp', '{}'))
        while self._store.remove_batch(before):
            pass
        self._is_new = True

    def book(self, slots: Sequence[KeptSlot], states: Sequence[KeptState]) -> None:
        scripts = [KeptScript('digest', '{}')]
        self._store.keep_books(Books(self._store.history, 0, True, slots, states, scripts))
        self._is_new = True

    def change(self, statement: str) -> None:
        """Do what a damaged disk of the database does."""
        assert self.records is not None, 'the feed comes first'
        settings = ['SET search_path = cell_1']
        with connected(place_of(self._address), 'test', settings) as connection:
            connection.execute(statement.encode())

    def close(self) -> None:
        if self._records is not None:
            self._records.close()
        self._store.close()


class TestOfACopy(KeptRecordsContract):
    server: PostgresServer

    @pytest.fixture(autouse=True)
    def _server(self, server: PostgresServer) -> None:
        self.server = server

    def make(self, folder: Path) -> Kept:
        return _Copied(self.server.place(self.server.database(), 'line_1'), folder)

    @pytest.mark.parametrize('newest_first', [False, True])
    @pytest.mark.parametrize(('first', 'last'), [(1, 2)], ids=['beginning'])
    def test_records_lost_at_either_end_are_told(  # of the end nobody knows: it may come yet
        self, written: Kept, newest_first: bool, first: int, last: int
    ) -> None:
        super().test_records_lost_at_either_end_are_told(written, newest_first, first, last)


def feed(path: Path, address: str) -> None:
    main(['feed', '--journal', str(path), '--to', address])


def write(path: Path, first: int, last: int, history: str) -> None:
    start = OrchestratorStarted(seq=first, cell='c', digest='d', history=history)
    with closing(SqliteStore(path, synchronous='NORMAL')) as store:
        store.append([start, *events(first + 1, last)])


def begun(path: Path) -> None:
    with closing(SqliteStore(path)) as store:
        history = store.history
    write(path, 1, 8, history)


def seqs_and_texts(records: Records) -> list[tuple[int, str]]:
    return [(record.seq, record.text) for record in records.page(Wanted()).records]


def of_file(path: Path) -> list[tuple[int, str]]:
    with closing(sqlite3.connect(path)) as database:
        return database.execute('SELECT seq, record FROM events ORDER BY seq').fetchall()


def test_restored_cell_reads_like_its_journal(server: PostgresServer, tmp_path: Path) -> None:
    """Its first events are those of the history before; a reader that is open follows."""
    path, address = tmp_path / 'journal.sqlite3', server.place(server.database(), 'line_1')
    begun(path)
    copy = Path(shutil.copy(path, tmp_path / 'backup'))
    with closing(SqliteStore(path)) as store:
        store.append(events(9, 12))
    feed(path, address)
    with closing(PostgresRecords(address)) as records:
        old = records.extent()
        assert seqs_and_texts(records) == of_file(path)
        for first, last in ((9, 10), (11, 15)):
            copy = Path(shutil.copy(path if first > 9 else copy, tmp_path / f'backup_{first}'))
            write(path, first, last, bring_back(copy, path, move_aside=True).history)
            feed(path, address)
            assert seqs_and_texts(records) == of_file(path)
            assert records.extent().last_seq == last
        assert records.extent().history != old.history


def test_gaps_are_told_as_such(server: PostgresServer, tmp_path: Path) -> None:
    path, address = tmp_path / 'journal.sqlite3', server.place(server.database(), 'line_1')
    begun(path)
    feed(path, address)
    with closing(SqliteStore(path)) as store:
        store.append(events(9, 30))
        store.begin_with(Snapshot(19, 'stamp', '{}'))
        assert not store.remove_batch(20)
    feed(path, address)
    with closing(PostgresRecords(address)) as records:
        page = records.page(Wanted())
        assert [record.seq for record in page.records] == [*range(1, 9), *range(20, 31)]
        (damage,) = page.damage
        assert damage.number == 11
        assert 'events 9 to 19 were removed from the journal before they could' in damage.what


def test_a_cell_without_a_copy_is_refused(server: PostgresServer, tmp_path: Path) -> None:
    database = server.database()
    with pytest.raises(JournalUnusable, match='has no cells of a plant'):
        PostgresRecords(server.place(database, 'line_1'))
