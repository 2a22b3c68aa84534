"""The rows of events: checked when they are read, and removed from the front, always by jobs."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Iterator
from contextlib import closing
from typing import NamedTuple

from bt_orchestrator.base.errors import DamagedRecord
from bt_orchestrator.model.codec import from_record
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.limits import fitting
from bt_orchestrator.store.shared import books
from bt_orchestrator.store.shared.database import Check, Database, check_of_event
from bt_orchestrator.store.shared.history import keep_from

_PAGE, _PAGE_BYTES = 1000, 1_000_000
"""Limits of one query: events, and bytes of their records."""

BATCH = 2000
"""Most events that one transaction removes."""


COLUMNS = 'seq, CAST(record AS BLOB), checksum, ends'
"""Those of a `Row`."""


class Row(NamedTuple):
    """The row of an event in the file."""

    seq: int
    text: bytes
    checksum: int | None
    ends: int | None

    def is_sound(self, checked_from: int, check: Check = check_of_event) -> bool:
        """Tell whether the row is undamaged, as far as that can be checked.

        :param checked_from: events before this one were written without a check
        """
        if self.checksum is None:
            return self.seq < checked_from and _is_json(self.text)
        return self.checksum == check(self.seq, self.text, self.ends or 0)


def _is_json(text: bytes) -> bool:
    try:
        json.loads(text)
    except ValueError:
        return False
    return True


def page(database: Database, after: int, last: int, most: int) -> list[Row]:
    """Return the next rows, if any; no query stays open, as that would keep the file open.

    :param most: maximum number; -1: as many as one query reads
    """
    query = f'SELECT {COLUMNS} FROM events WHERE seq > ? AND seq <= ? ORDER BY seq LIMIT ?'
    wanted = _PAGE if most < 0 else min(most, _PAGE)
    with closing(database.execute(query, (after, last, wanted))) as rows:
        return list(fitting(map(Row._make, rows), _PAGE_BYTES, lambda row: len(row.text)))


def events_of(
    rows: Iterable[Row], before: int, checked_from: int, check: Check = check_of_event
) -> Iterator[Event]:
    """Yield the events of consecutive rows; a damaged commit yields no event.

    :param before: the event that came before these
    :raises DamagedRecord: this one is damaged or missing
    """
    commit: list[Event] = []
    for row in rows:
        if row.seq != before + 1:
            raise DamagedRecord(before + 1, row.seq - 1, 'not there')
        if not row.is_sound(checked_from, check):
            raise DamagedRecord(row.seq, row.seq, 'damaged')
        commit.append(from_record(json.loads(row.text)))
        before = row.seq
        if row.ends != 0:
            yield from commit
            commit.clear()
    yield from commit


def last_seq(database: Database) -> int:
    """Return the seq of the last event; 0: there is none."""
    (last,) = database.execute('SELECT coalesce(max(seq), 0) FROM events').fetchone()
    return int(last)


def remove_after(database: Database, seq: int) -> None:
    """Remove the rows after an event."""
    for table in ('events', 'queued', 'snapshots'):
        database.execute(f'DELETE FROM {table} WHERE seq > ?', (seq,))
    books.forget(database, seq)


def first_needed(database: Database, live: Collection[str], keep_jobs: int) -> int:
    """Return the seq of the first event that must stay; 0: none has to go.

    That is the beginning of the first job that is live or among the last `keep_jobs` others. So
    every such job is kept from its beginning.
    """
    queued = database.execute('SELECT seq, job FROM queued ORDER BY seq').fetchall()
    others = [seq for seq, job in queued if job not in live]
    if len(others) <= keep_jobs:
        return 0
    last = database.execute('SELECT max(seq) FROM events').fetchone()[0]
    needed = [seq for seq, job in queued if job in live] + others[len(others) - keep_jobs :]
    return int(min(needed, default=last + 1))


def remove_batch(database: Database, before: int) -> bool:
    """Remove the first events before a seq; return whether there are more.

    Never removes what replay needs: the events after the state that it begins with.
    """
    first = database.execute('SELECT min(seq) FROM events').fetchone()[0]
    if first is None:
        return False
    kept = database.execute('SELECT coalesce(max(seq), 0) FROM beginning').fetchone()[0]
    end = min(before, kept + 1)
    now = min(end, first + BATCH)
    for table in ('events', 'queued'):
        database.execute(f'DELETE FROM {table} WHERE seq < ?', (now,))
    # The state at the event before stays: the remaining past states need it.
    database.execute('DELETE FROM snapshots WHERE seq < ?', (now - 1,))
    books.forget_states(database, now)
    keep_from(database, now)
    return bool(first + BATCH < end)
