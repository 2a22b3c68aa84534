"""The contract of readers, on a database: while a node writes it, and between two nodes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path

import pytest
from contract.records_contract import Kept, KeptRecordsContract
from postgres_server import PostgresServer

from bt_orchestrator.extensions.postgres.connecting import connected, place_of
from bt_orchestrator.extensions.postgres.journal import PostgresStore
from bt_orchestrator.extensions.postgres.records import PostgresRecords
from bt_orchestrator.model.books import Books, KeptScript, KeptSlot, KeptState
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.jobs.job_record import JobRecord
from bt_orchestrator.ports import Records, Snapshot


class _Database:
    """A journal in a database, and who reads it; between two writes no node has it."""

    def __init__(self, address: str, folder: Path) -> None:
        self._address = address
        self._folder = folder
        self._store().close()
        self.records: Records = PostgresRecords(address, folder)

    def _store(self) -> PostgresStore:
        return PostgresStore(self._address, self._folder)

    @contextmanager
    def node(self) -> Iterator[PostgresStore]:
        """Give the journal as a node has it."""
        with closing(self._store()) as store:
            yield store

    def append(self, events: Sequence[Event]) -> None:
        with self.node() as store:
            store.append(events)

    def save(self, ended: Sequence[JobRecord]) -> None:
        last = self.records.extent().last_seq
        with self.node() as store:
            store.save(Snapshot(last, 'stamp', '{}'), ended)

    def remove(self, before: int) -> None:
        with self.node() as store:
            store.begin_with(Snapshot(before - 1, 'stamp', '{}'))
            while store.remove_batch(before):
                pass

    def spoil(self, seq: int) -> None:
        self.change(f"UPDATE events SET record = replace(record, '{seq}', '7') WHERE seq = {seq}")

    def lose(self, first: int, last: int) -> None:
        self.change(f'DELETE FROM events WHERE seq BETWEEN {first} AND {last}')

    def book(self, slots: Sequence[KeptSlot], states: Sequence[KeptState]) -> None:
        history = self.records.extent().history
        scripts = [KeptScript('digest', '{}')]
        with self.node() as store:
            store.keep_books(Books(history, 0, True, slots, states, scripts))

    def spoil_book(self, begin_us: int) -> None:
        self.change(f"UPDATE book_slots SET slot = '{{}}' WHERE begin_us = {begin_us}")
        newest = '(SELECT max(seq) FROM book_states)'
        self.change(f"UPDATE book_states SET state = '{{}}' WHERE seq = {newest}")
        self.change("UPDATE book_scripts SET script = 'x'")

    def spoil_summary(self, job: str) -> None:
        self.change(f"UPDATE jobs SET summary = replace(summary, '3', '4') WHERE job = '{job}'")

    def change(self, statement: str) -> None:
        """Do what a damaged disk does."""
        settings = ['SET search_path = cell_1']
        with connected(place_of(self._address), 'test', settings) as connection:
            connection.execute(statement.encode())

    def close(self) -> None:
        self.records.close()


class _Written(_Database):
    """The same, and one node has it all the time."""

    def __init__(self, address: str, folder: Path) -> None:
        super().__init__(address, folder)
        self._node = self._store()

    @contextmanager
    def node(self) -> Iterator[PostgresStore]:
        yield self._node

    def close(self) -> None:
        super().close()
        self._node.close()


class TestBetweenTwoNodes(KeptRecordsContract):
    kind = _Database
    server: PostgresServer

    @pytest.fixture(autouse=True)
    def _server(self, server: PostgresServer) -> None:
        self.server = server

    def make(self, folder: Path) -> Kept:
        return self.kind(self.server.place(self.server.database(), 'line_1'), folder)


class TestWhileItIsWritten(TestBetweenTwoNodes):
    kind = _Written
