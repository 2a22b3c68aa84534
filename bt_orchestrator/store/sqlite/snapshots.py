"""States to start from, in the file of the journal."""

from __future__ import annotations

import hashlib
import logging
import sqlite3
from collections.abc import Sequence

from bt_orchestrator.ports import Snapshot

log = logging.getLogger(__name__)

KEPT = 2
"""So many of the newest snapshots stay: should one be damaged, there is another."""

_ROW = 'seq, stamp, checksum, CAST(state AS BLOB)'
"""As bytes: damaged ones need not be a text."""


def kept(database: sqlite3.Connection) -> Sequence[int]:
    """Return the events of which there are snapshots, newest first."""
    try:
        rows = database.execute('SELECT seq FROM snapshots ORDER BY seq DESC').fetchall()
    except sqlite3.Error as error:
        log.warning('the snapshots of the journal cannot be read (%s) and are ignored', error)
        return []
    return [seq for (seq,) in rows]


def sound_snapshot(database: sqlite3.Connection, seq: int) -> Snapshot | None:
    """Return a snapshot; None, with a warning, if it is damaged."""
    try:
        row = database.execute(f'SELECT {_ROW} FROM snapshots WHERE seq = ?', (seq,)).fetchone()
    except sqlite3.Error as error:
        log.warning('the state kept at event %d cannot be read (%s)', seq, error)
        return None
    return None if row is None else _sound(row)


def beginning(database: sqlite3.Connection) -> Snapshot | None:
    """Return the state that the first events came to, if some were removed.

    :raises ValueError: it is damaged
    """
    row = database.execute(f'SELECT {_ROW} FROM beginning').fetchone()
    if row is None:
        return None
    snapshot = _sound(row)
    if snapshot is None:
        raise ValueError(f'the state at event {row[0]}, before which events were removed')
    return snapshot


def keep_snapshot(database: sqlite3.Connection, snapshot: Snapshot) -> None:
    """Add a snapshot and drop the oldest."""
    row = (snapshot.seq, snapshot.stamp, _checksum(snapshot), snapshot.state)
    database.execute('INSERT OR REPLACE INTO snapshots VALUES (?, ?, ?, ?)', row)
    database.execute(
        'DELETE FROM snapshots WHERE seq NOT IN '
        '(SELECT seq FROM snapshots ORDER BY seq DESC LIMIT ?)',
        (KEPT,),
    )


def begin_with(database: sqlite3.Connection, snapshot: Snapshot) -> None:
    """Let replay begin with a state, from now on."""
    row = (snapshot.seq, snapshot.stamp, _checksum(snapshot), snapshot.state)
    database.execute('INSERT OR REPLACE INTO beginning VALUES (1, ?, ?, ?, ?)', row)


def _sound(row: tuple[int, str, str, bytes]) -> Snapshot | None:
    seq, stamp, checksum, text = row
    try:
        snapshot = Snapshot(seq, stamp, text.decode())
    except UnicodeDecodeError:
        snapshot = None
    if snapshot is None or checksum not in (_checksum(snapshot), _checksum_before_4(snapshot)):
        log.warning('the state kept at event %d is damaged', seq)
        return None
    return snapshot


def _checksum(snapshot: Snapshot) -> str:
    return _digest(f'{snapshot.seq} {snapshot.state}')


def _checksum_before_4(snapshot: Snapshot) -> str:
    """Return that of older schemas: over the state alone."""
    return _digest(snapshot.state)


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()
