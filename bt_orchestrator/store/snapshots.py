"""States to start from, in the file of the journal."""

from __future__ import annotations

import hashlib
import logging
import sqlite3
from collections.abc import Iterator

from bt_orchestrator.ports import Snapshot

log = logging.getLogger(__name__)

KEPT = 2
"""So many of the newest snapshots stay: should one be damaged, there is another."""


def sound_snapshots(database: sqlite3.Connection) -> Iterator[Snapshot]:
    """Yield the snapshots, newest first; one that is damaged is passed over with a warning."""
    newest_first = 'SELECT seq, stamp, checksum, state FROM snapshots ORDER BY seq DESC'
    try:
        for row in database.execute(newest_first).fetchall():
            snapshot = _sound(row)
            if snapshot is not None:
                yield snapshot
    except sqlite3.Error as error:
        log.warning('the snapshots of the journal cannot be read (%s) and are ignored', error)


def beginning(database: sqlite3.Connection) -> Snapshot | None:
    """Return the state that the first events came to, if some were removed.

    :raises ValueError: it is damaged
    """
    row = database.execute('SELECT seq, stamp, checksum, state FROM beginning').fetchone()
    if row is None:
        return None
    snapshot = _sound(row)
    if snapshot is None:
        raise ValueError(f'the state at event {row[0]}, before which events were removed')
    return snapshot


def keep_snapshot(database: sqlite3.Connection, snapshot: Snapshot) -> None:
    """Add a snapshot and drop the oldest."""
    row = (snapshot.seq, snapshot.stamp, _checksum(snapshot.state), snapshot.state)
    database.execute('INSERT OR REPLACE INTO snapshots VALUES (?, ?, ?, ?)', row)
    database.execute(
        'DELETE FROM snapshots WHERE seq NOT IN '
        '(SELECT seq FROM snapshots ORDER BY seq DESC LIMIT ?)',
        (KEPT,),
    )


def begin_with(database: sqlite3.Connection, snapshot: Snapshot) -> None:
    """Let replay begin with a state, from now on."""
    row = (snapshot.seq, snapshot.stamp, _checksum(snapshot.state), snapshot.state)
    database.execute('INSERT OR REPLACE INTO beginning VALUES (1, ?, ?, ?, ?)', row)


def _sound(row: tuple[int, str, str, str]) -> Snapshot | None:
    seq, stamp, checksum, state = row
    if checksum != _checksum(state):
        log.warning('the state kept at event %d is damaged', seq)
        return None
    return Snapshot(seq, stamp, state)


def _checksum(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()
