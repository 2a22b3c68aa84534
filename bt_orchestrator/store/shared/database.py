"""A database as both stores see it, and the check of each row: a changed bit is detected."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterable, Sequence
from typing import Any, Protocol


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
    instead = ', '.join(f'{one} = excluded.{one}' for one in others.split(', '))
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
