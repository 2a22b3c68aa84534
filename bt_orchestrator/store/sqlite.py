"""The durable journal: an SQLite file (semantics 9.1)."""

from __future__ import annotations

import fcntl
import json
import os
import sqlite3
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import IO, TypeVar

from bt_orchestrator.errors import JournalFailed, OrchestratorError
from bt_orchestrator.model.codec import from_record, to_record
from bt_orchestrator.model.events import Event

SCHEMA = 1
"""Version of the tables, kept in SQLite's user_version."""

APPLICATION_ID = 0x62746F72
"""Says that a file is a journal of ours (`btor`), and not some other SQLite file."""

_TABLES = 'CREATE TABLE events (seq INTEGER PRIMARY KEY, record TEXT NOT NULL) STRICT'

_T = TypeVar('_T')


class JournalUnusable(OrchestratorError):
    """The journal cannot be opened; nothing in it was changed."""


class SqliteStore:
    """A journal in a file. Implements `ports.EventStore`.

    One transaction an append, in WAL mode, so that others may read while it is written. A lock on
    a file beside it keeps a second orchestrator out for as long as this one lives, and is gone
    when its process is, however that ends.
    """

    def __init__(self, path: Path, *, synchronous: str = 'FULL') -> None:
        """Open or make a journal.

        :param synchronous: FULL (a power cut loses nothing) or NORMAL (it may lose the last
            events; a crash of the program loses nothing)
        :raises JournalUnusable: it is in use, not ours, newer, damaged, or cannot be written
        """
        self._path = path
        self._lock = _locked(path)
        try:
            self._database = _unusable_otherwise(path, lambda: _opened(path, synchronous))
        except BaseException:
            self._lock.close()
            raise

    def append(self, events: Sequence[Event]) -> None:
        """Make the events durable, all or none.

        :raises JournalFailed: they are not; nothing of them is in the journal
        """
        rows = [(event.seq, json.dumps(to_record(event), ensure_ascii=False)) for event in events]
        try:
            with _transaction(self._database):
                self._database.executemany('INSERT INTO events VALUES (?, ?)', rows)
        except sqlite3.Error as error:
            raise JournalFailed(f'the journal {self._path} cannot be written: {error}') from error

    def read(self, after: int = 0) -> list[Event]:
        """Return the events with a seq greater than `after`, oldest first.

        :raises JournalUnusable: the file is damaged
        """
        query = 'SELECT record FROM events WHERE seq > ? ORDER BY seq'
        return _unusable_otherwise(
            self._path,
            lambda: [
                from_record(json.loads(record))
                for (record,) in self._database.execute(query, (after,))
            ],
        )

    def close(self) -> None:
        """Close the file and let others have it."""
        self._database.close()
        self._lock.close()


def _locked(path: Path) -> IO[str]:
    """Take the lock beside a journal."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        lock = path.with_name(path.name + '.lock').open('a+')
    except OSError as error:
        raise JournalUnusable(f'the journal {path} cannot be opened: {error.strerror}') from error
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        lock.seek(0)
        owner = lock.read().strip() or 'unknown'
        lock.close()
        raise JournalUnusable(
            f'the journal {path} is in use by another orchestrator (process {owner}); stop that '
            'one, or name another file'
        ) from None
    lock.truncate(0)
    lock.write(f'{os.getpid()}\n')
    lock.flush()
    return lock


def _opened(path: Path, synchronous: str) -> sqlite3.Connection:
    database = sqlite3.connect(path, isolation_level=None, timeout=10.0)
    try:
        _check_ours(database, path)
        database.execute('PRAGMA journal_mode = WAL')
        database.execute(f'PRAGMA synchronous = {synchronous}')
        if _pragma(database, 'user_version') == 0:
            _make(database)
        else:
            _check_writable(database)
    except BaseException:
        database.close()
        raise
    return database


def _check_ours(database: sqlite3.Connection, path: Path) -> None:
    version = _pragma(database, 'user_version')
    tables = database.execute('SELECT count(*) FROM sqlite_schema').fetchone()[0]
    if _pragma(database, 'application_id') != APPLICATION_ID and (version or tables):
        raise JournalUnusable(f'{path} is an SQLite file, but no journal of an orchestrator')
    if version > SCHEMA:
        raise JournalUnusable(
            f'the journal {path} has schema {version}, this program knows {SCHEMA}; use the newer '
            'program, or name another file'
        )


def _check_writable(database: sqlite3.Connection) -> None:
    with _transaction(database):
        database.execute(f'PRAGMA user_version = {SCHEMA}')


def _make(database: sqlite3.Connection) -> None:
    with _transaction(database):
        database.execute(_TABLES)
        database.execute(f'PRAGMA application_id = {APPLICATION_ID}')
        database.execute(f'PRAGMA user_version = {SCHEMA}')


def _pragma(database: sqlite3.Connection, name: str) -> int:
    return int(database.execute(f'PRAGMA {name}').fetchone()[0])


@contextmanager
def _transaction(database: sqlite3.Connection) -> Iterator[None]:
    database.execute('BEGIN IMMEDIATE')
    try:
        yield
        database.execute('COMMIT')
    except BaseException:
        if database.in_transaction:
            database.execute('ROLLBACK')
        raise


def _unusable_otherwise(path: Path, work: Callable[[], _T]) -> _T:
    try:
        return work()
    except sqlite3.Error as error:
        raise JournalUnusable(f'the journal {path} cannot be used: {error}') from error
    except (KeyError, TypeError, ValueError) as error:
        raise JournalUnusable(
            f'the journal {path} holds a record that cannot be read: {error!r}'
        ) from error
