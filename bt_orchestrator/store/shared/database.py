"""A database as both stores see it, its history, and the check of each row."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple, Protocol


class Database(Protocol):
    """An open connection. It speaks the SQL that SQLite and PostgreSQL share, with `?` for values.

    A text is read as bytes with `CAST(column AS BLOB)`: a damaged one may not be valid text.
    """

    @property
    def Error(self) -> type[Exception]:  # noqa: N802 - PEP 249
        """Base of its errors."""

    def execute(self, query: str, values: Sequence[Any] = ..., /) -> Any:
        """Carry out a statement; its rows have `fetchone`, `fetchall` and `close`."""

    def executemany(self, query: str, rows: Iterable[Sequence[Any]], /) -> object:
        """Carry out a statement once for each row of values."""


def replace(
    database: Database, table: str, keys: str, others: str, rows: Iterable[Sequence[Any]]
) -> None:
    """Write rows; each takes the place of the one with its keys.

    :param keys: names of columns, with commas; the rows begin with them
    """
    columns = f'{keys}, {others}'.split(', ')
    marks = ', '.join('?' * len(columns))
    instead = ', '.join(f'{column} = excluded.{column}' for column in others.split(', '))
    database.executemany(
        f'INSERT INTO {table} ({", ".join(columns)}) VALUES ({marks}) '
        f'ON CONFLICT ({keys}) DO UPDATE SET {instead}',
        rows,
    )


def check_of(key: int, text: bytes) -> int:
    """Return the check of a row: CRC-32 over its text, seeded with its key.

    It detects errors of disk and memory. It does not detect a deliberate change of a row and its
    check.
    """
    return zlib.crc32(text, key & 0xFFFFFFFF)


Check = Callable[[int, bytes, int], int]
"""Returns the check of the row of an event: `check_of_event`, or what a database can do itself."""


def check_of_event(seq: int, text: bytes, ends: int) -> int:
    """Return the check of the row of an event.

    :param ends: 1: it is the last one of its commit; 0: it is not
    """
    return check_of(2 * seq + ends, text)


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
