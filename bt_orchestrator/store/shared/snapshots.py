"""Past states in a journal, to start from and to look back, with the ids that they name.

The newest are for the next start. Some older ones stay as keyframes: a past state is replayed from
the nearest one and not from the beginning.
"""

from __future__ import annotations

import hashlib
import logging
from collections.abc import Sequence

from bt_orchestrator.model.judging.used_ids import SealedIds, digest_of
from bt_orchestrator.ports import Snapshot
from bt_orchestrator.store.shared.database import Database, replace

log = logging.getLogger(__name__)

NEWEST = 2
"""Number of the newest snapshots kept for a start: a second one in case of damage."""

KEYFRAME_EVERY = 1000
"""Minimum number of events from one keyframe to the next."""

KEYFRAME_BYTES = 20
"""Maximum bytes of keyframes per event: a few percent of the event's own size."""

_ROW = 'seq, stamp, checksum, CAST(state AS BLOB)'
"""Read as bytes: damaged ones may not be valid text."""


def kept(database: Database) -> Sequence[int]:
    """Return the events with snapshots to start from, newest first."""
    try:
        query = 'SELECT seq FROM snapshots ORDER BY seq DESC LIMIT ?'
        rows = database.execute(query, (NEWEST,)).fetchall()
    except database.Error as error:
        log.warning('the snapshots of the journal cannot be read (%s) and are ignored', error)
        return []
    return [seq for (seq,) in rows]


def sound_snapshot(database: Database, seq: int) -> Snapshot | None:
    """Return a snapshot; None, with a warning, if it is damaged."""
    try:
        row = database.execute(f'SELECT {_ROW} FROM snapshots WHERE seq = ?', (seq,)).fetchone()
    except database.Error as error:
        log.warning('the state kept at event %d cannot be read (%s)', seq, error)
        return None
    return None if row is None else _sound(row)


def beginning(database: Database) -> Snapshot | None:
    """Return the state after the removed first events, if some were removed.

    :raises ValueError: it is damaged
    """
    row = database.execute(f'SELECT {_ROW} FROM beginning').fetchone()
    if row is None:
        return None
    snapshot = _sound(row)
    if snapshot is None:
        raise ValueError(f'the state at event {row[0]}, before which events were removed')
    return snapshot


def keep_snapshot(database: Database, snapshot: Snapshot) -> None:
    """Add a snapshot; of the earlier ones, the newest and the keyframes stay."""
    row = (snapshot.seq, snapshot.stamp, _checksum(snapshot), snapshot.state)
    replace(database, 'snapshots', 'seq', 'stamp, checksum, state', [row])
    query = 'SELECT seq, length(state) FROM snapshots ORDER BY seq DESC LIMIT ?'
    newest = database.execute(query, (NEWEST + 2,)).fetchall()
    if len(newest) == NEWEST + 2:
        (seq, size), (before, _) = newest[NEWEST:]
        if not _is_keyframe(seq, size, before):
            database.execute('DELETE FROM snapshots WHERE seq = ?', (seq,))


def _is_keyframe(seq: int, size: int, before: int) -> bool:
    """Tell whether a state is kept as keyframe, by its size and its distance from the last one."""
    behind = seq - before
    return behind >= KEYFRAME_EVERY and size <= KEYFRAME_BYTES * behind


def state_before(database: Database, seq: int) -> Snapshot | None:
    """Return the newest sound state at an event or before it; None: there is none."""
    query = 'SELECT seq FROM snapshots WHERE seq <= ? ORDER BY seq DESC'
    for (number,) in database.execute(query, (seq,)).fetchall():
        snapshot = sound_snapshot(database, number)
        if snapshot is not None:
            return snapshot
    start = beginning(database)
    return start if start is not None and start.seq <= seq else None


def begin_with(database: Database, snapshot: Snapshot) -> None:
    """Let replay begin with a state, from now on."""
    row = (1, snapshot.seq, snapshot.stamp, _checksum(snapshot), snapshot.state)
    replace(database, 'beginning', 'one', 'seq, stamp, checksum, state', [row])


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
    """Return the checksum of older schemas: over the state alone."""
    return _digest(snapshot.state)


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


# Sealed parts of the ids that were ever used, which states in the journal name (decision 0042).
#
# The events that they came from may have been removed, so each part is there twice.

COPIES = (1, 2)


def keep_ids(database: Database, part: SealedIds) -> None:
    """Write a part; it takes the place of one that is damaged."""
    rows = [(part.digest, copy, part.text) for copy in COPIES]
    replace(database, 'used_ids', 'digest, copy', 'ids', rows)


def sound_copies(database: Database, digest: str) -> list[str]:
    """Return the text of a part, once for each copy that is whole."""
    texts = [_read(database, digest, copy) for copy in COPIES]
    sound = [text for text in texts if text is not None]
    if len(sound) < len(COPIES):
        log.warning(
            'the journal has %d of %d copies of the used ids %s', len(sound), len(COPIES), digest
        )
    return sound


def _read(database: Database, digest: str, copy: int) -> str | None:
    """Return the text of one copy; None: it is not there, or damaged."""
    query = 'SELECT CAST(ids AS BLOB) FROM used_ids WHERE digest = ? AND copy = ?'
    try:
        row = database.execute(query, (digest, copy)).fetchone()
        text = None if row is None else row[0].decode()
    except (database.Error, UnicodeDecodeError):
        return None
    return text if text is not None and digest_of(text) == digest else None
