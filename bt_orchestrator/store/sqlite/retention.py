"""Removing the events of jobs that ended long ago, always from the front."""

from __future__ import annotations

import sqlite3
from collections.abc import Collection

from bt_orchestrator.store.sqlite import books
from bt_orchestrator.store.sqlite.schema import keep_from

BATCH = 2000
"""Most events that one transaction removes."""


def first_needed(database: sqlite3.Connection, live: Collection[str], keep_jobs: int) -> int:
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


def remove_batch(database: sqlite3.Connection, before: int) -> bool:
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
