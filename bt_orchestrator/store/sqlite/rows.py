"""The rows of events: written with a check, which is verified when they are read."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterable, Iterator, Sequence
from contextlib import closing
from itertools import chain
from typing import NamedTuple

from bt_orchestrator.base.errors import DamagedRecord
from bt_orchestrator.model.codec import from_record, to_text
from bt_orchestrator.model.events import Event, JobQueued
from bt_orchestrator.model.limits import fitting
from bt_orchestrator.store.sqlite import books
from bt_orchestrator.store.sqlite.checks import check_of_event
from bt_orchestrator.store.sqlite.database import transaction

_AT_ONCE = 50
"""Most events that are written with one statement; a settle has a few."""

_PAGE, _PAGE_BYTES = 1000, 1_000_000
"""Limits of one query: events, and bytes of their records."""

_INSERT = 'INSERT INTO events (seq, record, checksum, ends) VALUES '
_ONE = '(?, ?, ?, ?)'


def add(database: sqlite3.Connection, events: Sequence[Event]) -> None:
    """Write the events of one commit, all or none.

    In a transaction of its own, unless one is open.
    """
    rows = [_row(event, 0) for event in events[:-1]] + [_row(event, 1) for event in events[-1:]]
    queued = [(event.seq, event.job) for event in events if type(event) is JobQueued]
    if len(rows) <= _AT_ONCE and not queued:  # one statement is a transaction, and takes less time
        values = ', '.join([_ONE] * len(rows))
        database.execute(_INSERT + values, tuple(chain(*rows)))
    elif database.in_transaction:
        _add_each(database, rows, queued)
    else:
        with transaction(database):
            _add_each(database, rows, queued)


def _add_each(
    database: sqlite3.Connection,
    rows: Sequence[tuple[int, str, int, int]],
    queued: Sequence[tuple[int, str]],
) -> None:
    database.executemany(_INSERT + _ONE, rows)
    database.executemany('INSERT INTO queued VALUES (?, ?)', queued)


def _row(event: Event, ends: int) -> tuple[int, str, int, int]:
    text = to_text(event)
    return event.seq, text, check_of_event(event.seq, text.encode(), ends), ends


class Row(NamedTuple):
    """The row of an event in the file."""

    seq: int
    text: bytes
    checksum: int | None
    ends: int | None

    def is_sound(self, checked_from: int) -> bool:
        """Tell whether the row is undamaged, as far as that can be checked.

        :param checked_from: events before this one were written without a check
        """
        if self.checksum is None:
            return self.seq < checked_from
        return self.checksum == check_of_event(self.seq, self.text, self.ends or 0)


def page(database: sqlite3.Connection, after: int, last: int, most: int) -> list[Row]:
    """Return the next rows, if any; no query stays open, as that would keep the file open.

    :param most: maximum number; -1: as many as one query reads
    """
    query = (
        'SELECT seq, CAST(record AS BLOB), checksum, ends FROM events '
        'WHERE seq > ? AND seq <= ? ORDER BY seq LIMIT ?'
    )
    wanted = _PAGE if most < 0 else min(most, _PAGE)
    with closing(database.execute(query, (after, last, wanted))) as rows:
        return list(fitting(map(Row._make, rows), _PAGE_BYTES, lambda row: len(row.text)))


def events_of(rows: Iterable[Row], before: int, checked_from: int) -> Iterator[Event]:
    """Yield the events of consecutive rows; a damaged commit yields no event.

    :param before: the event that came before these
    :raises DamagedRecord: this one is damaged or missing
    """
    commit: list[Event] = []
    for row in rows:
        if row.seq != before + 1:
            raise DamagedRecord(before + 1, row.seq - 1, 'not there')
        if not row.is_sound(checked_from):
            raise DamagedRecord(row.seq, row.seq, 'damaged')
        commit.append(from_record(json.loads(row.text)))
        before = row.seq
        if row.ends != 0:
            yield from commit
            commit.clear()
    yield from commit


def last_seq(database: sqlite3.Connection) -> int:
    """Return the seq of the last event; 0: there is none."""
    (last,) = database.execute('SELECT coalesce(max(seq), 0) FROM events').fetchone()
    return int(last)


def remove_after(database: sqlite3.Connection, seq: int) -> None:
    """Remove the rows after an event."""
    for table in ('events', 'queued', 'snapshots'):
        database.execute(f'DELETE FROM {table} WHERE seq > ?', (seq,))
    books.forget(database, seq)
