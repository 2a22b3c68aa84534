"""One scan of the rows of events for the wanted records."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

from bt_orchestrator.base.errors import DamagedRecord
from bt_orchestrator.model.records import Record, Wanted
from bt_orchestrator.store.shared.database import Check, Database, check_of_event
from bt_orchestrator.store.shared.rows import COLUMNS, Row

MOST = 1000
"""Most records of a page."""

MOST_BYTES = 1_000_000
"""A page ends with the record that makes it this long."""

LOOKED_AT = 20_000
"""A page ends after so many rows, wanted or not: the log grows during a long scan."""


_AT_ONCE = 200
"""Rows of one query."""


class Terms(NamedTuple):
    """The terms of SQL for what may be wanted of a record; `?` is the value."""

    job: str
    since: str
    until: str
    event: str
    """By a name with `*` as wildcard."""
    if_sound: str = '{}'
    """Around a condition that fails on a damaged record."""
    check: Check = check_of_event
    """Of the rows."""

    def condition(self, wanted: Wanted) -> tuple[str, list[Any]]:
        """Return the SQL condition for wanted records, and its values."""
        terms = ((self.job, wanted.job), (self.since, wanted.since), (self.until, wanted.until))
        given = [(term, value) for term, value in terms if value is not None]
        parts = [term for term, _ in given]
        if wanted.events:
            parts.append(f'({" OR ".join([self.event] * len(wanted.events))})')
        values = [value for _, value in given]
        condition = self.if_sound.format(' AND '.join(parts) or 'TRUE')
        return condition, [*values, *wanted.patterns]


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

    def through(self, database: Database, terms: Terms, checked_from: int) -> None:
        """Scan the rows.

        :param checked_from: events before this one were written without a check
        """
        length = 0
        for looked, (seq, text) in enumerate(self._rows(database, terms, checked_from), 1):
            if seq != self._next:
                self._come_to(seq)
            self._next = seq + self._step
            if text is None:
                self.damaged.append(DamagedRecord(seq, seq, 'damaged'))
            elif text:
                length += len(text)
                self._take(seq, text)
            if len(self.found) == self._most or length > MOST_BYTES or looked == LOOKED_AT:
                self.rest = self._wanted.past(seq)
                return
        self._come_to_the_end()

    def _rows(
        self, database: Database, terms: Terms, checked_from: int
    ) -> Iterator[tuple[int, bytes | None]]:
        """Yield numbers with their record; None: it is damaged; empty: it is not wanted."""
        condition, values = terms.condition(self._wanted)
        order = 'DESC' if self._wanted.newest_first else 'ASC'
        query = (
            f'SELECT {condition}, {COLUMNS} FROM events '
            f'WHERE seq BETWEEN ? AND ? ORDER BY seq {order} LIMIT {_AT_ONCE}'
        )
        low, high = self._low, self._high
        while found := database.execute(query, (*values, low, high)).fetchall():
            for is_wanted, *columns in found:
                row = Row(*columns)
                text = row.text if is_wanted else b''
                yield row.seq, text if row.is_sound(checked_from, terms.check) else None
            low, high = (low, row.seq - 1) if self._wanted.newest_first else (row.seq + 1, high)

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
