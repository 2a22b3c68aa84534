"""The contract of readers, on files: while they are written, closed, and of older schemas."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from itertools import chain
from pathlib import Path

from contract.kept_tables import WrittenTables
from contract.records_contract import Kept, KeptRecordsContract, RecordsContract, Written

from bt_orchestrator.model.codec import to_text
from bt_orchestrator.model.events import Event
from bt_orchestrator.ports import Records
from bt_orchestrator.store.sqlite import schema
from bt_orchestrator.store.sqlite.records import SqliteRecords
from bt_orchestrator.store.sqlite.store import SqliteStore


def _store(path: Path) -> SqliteStore:
    return SqliteStore(path, synchronous='NORMAL')


class _File(WrittenTables):
    """A journal in a file, and who reads it; between two writes no node has it."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / 'journal.sqlite3'
        _store(self.path).close()
        self.records: Records = SqliteRecords(self.path)

    @contextmanager
    def node(self) -> Iterator[SqliteStore]:
        """Give the journal as a node has it."""
        self.records.close()
        with closing(_store(self.path)) as store:
            yield store
        self.records = SqliteRecords(self.path)

    def change(self, statement: str) -> None:
        """Do what a damaged disk does."""
        with closing(sqlite3.connect(self.path, isolation_level=None)) as database:
            database.execute(statement)

    def close(self) -> None:
        self.records.close()


class _Written(_File):
    """The same, and one node has it all the time."""

    def __init__(self, folder: Path) -> None:
        super().__init__(folder)
        self._store = _store(self.path)

    @contextmanager
    def node(self) -> Iterator[SqliteStore]:
        yield self._store

    def change(self, statement: str) -> None:
        """Over the connection of the node, or it would lose its locks."""
        self._store._database.execute(statement)

    def close(self) -> None:
        super().close()
        self._store.close()


class _Older(_File):
    """A journal as a program wrote it that knew fewer tables, and no checks."""

    def __init__(self, folder: Path, version: int) -> None:
        self.path = folder / 'journal.sqlite3'
        with closing(sqlite3.connect(self.path, isolation_level=None)) as database:
            database.execute('PRAGMA journal_mode = WAL')
            database.execute('PRAGMA synchronous = OFF')
            for statement in chain(*schema._STEPS[:version]):
                database.execute(statement)
            database.execute(f'PRAGMA application_id = {schema.APPLICATION_ID}')
            database.execute(f'PRAGMA user_version = {version}')
        self.records = SqliteRecords(self.path)

    def append(self, events: Sequence[Event]) -> None:
        rows = [(event.seq, to_text(event)) for event in events]
        with closing(sqlite3.connect(self.path, isolation_level=None)) as database:
            database.executemany('INSERT INTO events VALUES (?, ?)', rows)


class TestWhileItIsWritten(KeptRecordsContract):
    def make(self, folder: Path) -> Kept:
        return _Written(folder)


class TestBetweenTwoNodes(KeptRecordsContract):
    def make(self, folder: Path) -> Kept:
        return _File(folder)


class TestSchema1(RecordsContract):
    def make(self, folder: Path) -> Written:
        return _Older(folder, 1)


class TestSchema2(RecordsContract):
    def make(self, folder: Path) -> Written:
        return _Older(folder, 2)


class TestSchema3(RecordsContract):
    def make(self, folder: Path) -> Written:
        return _Older(folder, 3)
