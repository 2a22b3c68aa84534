"""Common SQLite functions: transactions, pragmas, errors in words."""

from __future__ import annotations

import sqlite3
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from bt_orchestrator.base.errors import JournalUnusable


@contextmanager
def transaction(database: sqlite3.Connection) -> Iterator[None]:
    """Commit all of it, or nothing."""
    database.execute('BEGIN IMMEDIATE')
    try:
        yield
        database.execute('COMMIT')
    except BaseException:
        if database.in_transaction:
            database.execute('ROLLBACK')
        raise


RESTORE = 'restore a backup that is intact'
"""The remedy for a damaged journal."""


def cannot_open(path: Path, why: str | None) -> str:
    """Say that the system does not let a journal be opened, and what to do."""
    return f'the journal {path} cannot be opened: {why}; check file and folder'


@contextmanager
def unusable_otherwise(path: Path) -> Iterator[None]:
    """Convert errors of SQLite to one that explains what is wrong with a journal.

    :raises JournalUnusable: the file, or a record in it, cannot be read
    """
    try:
        yield
    except sqlite3.Error as error:
        is_damage = not isinstance(error, sqlite3.OperationalError)
        hint = f'; {RESTORE}' if is_damage else ''
        raise JournalUnusable(f'the journal {path} cannot be used: {error}{hint}') from error
    except OSError as error:
        raise JournalUnusable(cannot_open(path, error.strerror)) from error
    except (KeyError, TypeError, ValueError) as error:
        raise JournalUnusable(
            f'the journal {path} holds a record that cannot be read: {error!r}; {RESTORE}'
        ) from error


_WRITTEN: set[Path] = set()
"""Journals that this process writes. It must not open them in any other way: in POSIX, closing any
descriptor of a file releases all locks of the process on that file."""


def is_written(path: Path) -> None:
    """Note that this process writes a journal."""
    _WRITTEN.add(path.resolve())


def no_longer_written(path: Path) -> None:
    """Note that it has closed it."""
    _WRITTEN.discard(path.resolve())


def log_of(path: Path) -> Path:
    """Return the write-ahead log beside a journal."""
    journal = path.resolve()
    return journal.with_name(journal.name + '-wal')


def log_size(database: sqlite3.Connection) -> int:
    """Return how many bytes of the log SQLite uses, after a checkpoint into the journal."""
    try:
        _, frames, _ = database.execute('PRAGMA wal_checkpoint(PASSIVE)').fetchone()
    except sqlite3.OperationalError:
        return sys.maxsize  # it finds less than it wants to read
    return _LOG_HEADER + frames * (_FRAME_HEADER + pragma(database, 'page_size')) if frames else 0


_LOG_HEADER, _FRAME_HEADER = 32, 24
"""Bytes, by SQLite's description of its file format."""


def has_log(path: Path) -> bool:
    """Tell whether the write-ahead log may have events that are not yet in the journal."""
    log = log_of(path)
    return log.exists() and log.stat().st_size > 0


def unchanging(path: Path) -> sqlite3.Connection:
    """Open a journal without a writer, and change no byte of it or of the files beside it.

    SQLite's read-only mode still creates or changes the index of the log beside a journal. Without
    a log the file is opened as immutable. With a log, SQLite in exclusive mode keeps the index in
    memory; locks are off, because it gets none on a read-only file.
    """
    assert path.resolve() not in _WRITTEN, f'who writes {path} would lose its locks by this'
    uri = f'{path.resolve().as_uri()}?mode=ro'
    if not has_log(path):
        return sqlite3.connect(f'{uri}&immutable=1', uri=True, check_same_thread=False)
    database = sqlite3.connect(f'{uri}&vfs=unix-none', uri=True, check_same_thread=False)
    database.execute('PRAGMA locking_mode = EXCLUSIVE')
    return database


def pragma(database: sqlite3.Connection, name: str) -> int:
    """Return the number of a pragma."""
    return int(database.execute(f'PRAGMA {name}').fetchone()[0])
