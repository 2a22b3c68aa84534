"""The contract of journals, in a file."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path

from contract.journal_contract import JournalContract

from bt_orchestrator.ports import Journal
from bt_orchestrator.store.sqlite.store import SqliteStore


class TestSqliteStore(JournalContract):
    def make(self, folder: Path) -> Journal:
        return SqliteStore(_file(folder))

    def spoil(self, folder: Path, seq: int) -> None:
        other = f"replace(record, '{seq}', '')"
        _change(folder, f'UPDATE events SET record = {other} WHERE seq = {seq}')

    def lose(self, folder: Path, first: int, last: int) -> None:
        _change(folder, f'DELETE FROM events WHERE seq BETWEEN {first} AND {last}')


def _file(folder: Path) -> Path:
    return folder / 'journal.sqlite3'


def _change(folder: Path, statement: str) -> None:
    with closing(sqlite3.connect(_file(folder), isolation_level=None)) as database:
        database.execute(statement)
