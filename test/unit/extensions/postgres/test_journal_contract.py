"""The contract of journals, in a database."""

from __future__ import annotations

from pathlib import Path

import pytest
from contract.journal_contract import JournalContract
from postgres_server import PostgresServer

from bt_orchestrator.extensions.postgres.connecting import connected, place_of
from bt_orchestrator.extensions.postgres.journal import PostgresStore
from bt_orchestrator.ports import Journal


class TestPostgresStore(JournalContract):
    server: PostgresServer
    database: str

    @pytest.fixture(autouse=True)
    def _place(self, server: PostgresServer) -> None:
        self.server, self.database = server, server.database()

    def make(self, folder: Path) -> Journal:
        return PostgresStore(self.server.place(self.database, folder.name), folder)

    def spoil(self, folder: Path, seq: int) -> None:
        other = f"replace(record, '{seq}', '')"
        self._change(f'UPDATE events SET record = {other} WHERE seq = {seq}')

    def lose(self, folder: Path, first: int, last: int) -> None:
        self._change(f'DELETE FROM events WHERE seq BETWEEN {first} AND {last}')

    def _change(self, statement: str) -> None:
        place = place_of(self.server.address(self.database))
        with connected(place, 'test', ['SET search_path = cell_1']) as connection:
            connection.execute(statement.encode())
