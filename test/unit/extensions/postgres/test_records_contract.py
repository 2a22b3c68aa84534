"""The contract of readers, on a database: while a node writes it, and between two nodes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest
from contract.kept_tables import WrittenTables
from contract.records_contract import Kept, KeptRecordsContract
from postgres_server import PostgresServer

from bt_orchestrator.extensions.postgres.connecting import connected, place_of
from bt_orchestrator.extensions.postgres.journal import PostgresStore
from bt_orchestrator.extensions.postgres.records import PostgresRecords
from bt_orchestrator.ports import Records


class _Database(WrittenTables):
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
