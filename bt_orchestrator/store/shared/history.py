"""The history that a journal holds, and where retention has begun to keep it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from bt_orchestrator.store.shared.database import Database, check_of


class History(NamedTuple):
    """The name of the history that a journal holds."""

    id: str
    is_restored: bool
    """It continues from a restored copy."""
    checked_from: int = 1
    """Events before this one have no checks."""


def history_of(database: Database) -> History:
    """Return the history in a journal.

    :raises ValueError: it has none, or it is damaged
    """
    row = database.execute(f'SELECT {_OF_HISTORY}, checksum FROM history').fetchone()
    if row is None:
        raise ValueError('the table history is empty')
    if row[-1] != _check(row[:-1]):
        raise ValueError('the row of the table history is damaged')
    return History(str(row[0]), bool(row[1]), int(row[2]))


def begin_history(database: Database, history: str, *, restored: bool = False) -> None:
    """Give a journal a new history id.

    :param restored: it continues from a copy
    """
    database.execute('UPDATE history SET id = ?, restored = ?', (history, int(restored)))
    seal(database)


def kept_from(database: Database) -> int:
    """Return the seq of the first event that retention has left; if none, of the next one."""
    query = 'SELECT coalesce(max(kept_from), 1) FROM history'  # empty if it is damaged
    return int(database.execute(query).fetchone()[0])


def keep_from(database: Database, seq: int) -> None:
    """Record that the events before this one are removed."""
    database.execute('UPDATE history SET kept_from = ? WHERE kept_from < ?', (seq, seq))
    seal(database)


_OF_HISTORY = 'id, restored, checked_from, kept_from'


def seal(database: Database) -> None:
    """Give the row its check, after a change."""
    row = database.execute(f'SELECT {_OF_HISTORY} FROM history').fetchone()
    database.execute('UPDATE history SET checksum = ?', (_check(row),))


def _check(row: Sequence[object]) -> int:
    return check_of(1, '\t'.join(str(value) for value in row).encode())
