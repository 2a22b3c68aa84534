"""One scan of the rows of events for the wanted records."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import closing
from typing import Any

from bt_orchestrator.base.errors import DamagedRecord
from bt_orchestrator.model.records import Record, Wanted

MOST = 1000
"""Most records of a page."""

MOST_BYTES = 1_000_000
"""A page ends with the record that makes it this long."""

LOOKED_AT = 20_000
"""A page ends after so many rows, wanted or not: the log grows during a long scan."""


class Look:
    """Finds the records of a page, and the damaged or missing ones between them."""

    def __init__(self, wanted: Wanted, low: int, high: int, most: int) -> None:
        """Begin.

        :param low: seq of the first event that must exist
        :param high: seq of the last one
        """
        self._wanted = wanted
        self._low, self._high = low, high
        self._most = max(1, min(most, MOST))
        self._next, self._step = (high, -1) if wanted.newest_first else (low, 1)
        """The expected number of the next row, and the step to the one after it."""
        self.found: list[Record] = []
        self.damaged: list[DamagedRecord] = []
        self.rest = wanted
        self.is_last = False

    def through(self, database: sqlite3.Connection, sound: str) -> None:
        """Scan the rows.

        :param sound: SQL condition for an undamaged row
        """
        length = 0
        for looked, (seq, text) in enumerate(self._rows(database, sound), 1):
            if seq != self._next:
                self._come_to(seq)
            self._next = seq + self._step
            if isinstance(text, bytes):
                length += len(text)
                self._take(seq, text)
            elif text is None:
                self.damaged.append(DamagedRecord(seq, seq, 'damaged'))
            if len(self.found) == self._most or length > MOST_BYTES or looked == LOOKED_AT:
                self.rest = self._wanted.past(seq)
                return
        self._come_to_the_end()

    def _rows(self, database: sqlite3.Connection, sound: str) -> Iterator[tuple[int, Any]]:
        """Yield numbers with their record; None: it is damaged; 0: it is not wanted."""
        condition, values = _condition(self._wanted)
        order = 'DESC' if self._wanted.newest_first else 'ASC'
        query = (
            f'SELECT seq, CASE WHEN {sound} THEN '
            f'CASE WHEN {condition} THEN CAST(record AS BLOB) ELSE 0 END END '
            f'FROM events WHERE seq BETWEEN ? AND ? ORDER BY seq {order}'
        )
        with closing(database.execute(query, (*values, self._low, self._high))) as rows:
            yield from rows

    def _take(self, seq: int, text: bytes) -> None:
        try:
            self.found.append(Record(seq, text.decode()))
        except UnicodeDecodeError:  # a row without a check
            self.damaged.append(DamagedRecord(seq, seq, 'damaged'))

    def _come_to(self, seq: int) -> None:
        """Note the rows missing before this one."""
        if self._wanted.newest_first:
            self._miss(seq + 1, self._next)
        else:
            self._miss(self._next, seq - 1)

    def _come_to_the_end(self) -> None:
        """Note the rows missing after the last one."""
        end = self._low - 1 if self._wanted.newest_first else self._high + 1
        self._come_to(end)
        self.rest = self._wanted.past(end + 1 if self._wanted.newest_first else end - 1)
        self.is_last = True

    def _miss(self, first: int, last: int) -> None:
        if first <= last:
            self.damaged.append(DamagedRecord(first, last, 'not there'))


def _condition(wanted: Wanted) -> tuple[str, list[Any]]:
    """Return the SQL condition for wanted records among sound ones."""
    parts: list[str] = ['1']
    found: list[Any] = []
    conditions = (
        ("json_extract(record, '$.job') = ?", wanted.job),
        ("json_extract(record, '$.time') >= ?", wanted.since),
        ("json_extract(record, '$.time') <= ?", wanted.until),
    )
    for part, value in conditions:
        if value is not None:
            parts.append(part)
            found.append(value)
    if wanted.events:
        parts.append(f'({" OR ".join([_EVENT_GLOB] * len(wanted.events))})')
        found += wanted.patterns
    return ' AND '.join(parts), found


_EVENT_GLOB = "json_extract(record, '$.event') GLOB ?"
