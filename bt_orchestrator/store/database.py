"""What every use of SQLite here needs: transactions, pragmas, errors in words."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from bt_orchestrator.errors import OrchestratorError


class JournalUnusable(OrchestratorError):
    """The journal cannot be opened or read; nothing in it was changed."""


@contextmanager
def transaction(database: sqlite3.Connection) -> Iterator[None]:
    """Do all of it, or nothing."""
    database.execute('BEGIN IMMEDIATE')
    try:
        yield
        database.execute('COMMIT')
    except BaseException:
        if database.in_transaction:
            database.execute('ROLLBACK')
        raise


@contextmanager
def unusable_otherwise(path: Path) -> Iterator[None]:
    """Say in words what is wrong with a journal.

    :raises JournalUnusable: the file, or a record in it, cannot be read
    """
    try:
        yield
    except sqlite3.Error as error:
        raise JournalUnusable(f'the journal {path} cannot be used: {error}') from error
    except (KeyError, TypeError, ValueError) as error:
        raise JournalUnusable(
            f'the journal {path} holds a record that cannot be read: {error!r}'
        ) from error


def pragma(database: sqlite3.Connection, name: str) -> int:
    """Return a number that SQLite keeps beside the tables."""
    return int(database.execute(f'PRAGMA {name}').fetchone()[0])
