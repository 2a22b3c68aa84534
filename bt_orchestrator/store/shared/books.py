"""Books in a journal: written by its node, read by reports (see `model.keeping.books`)."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from datetime import datetime, timezone

from bt_orchestrator.model.keeping.books import (
    Books,
    KeptReason,
    KeptScript,
    KeptSlot,
    KeptState,
    ReasonPage,
    SlotPage,
)
from bt_orchestrator.model.keeping.records import Damage
from bt_orchestrator.store.shared.database import Database, check_of, replace

log = logging.getLogger(__name__)

TABLES = ('book_slots', 'book_states', 'book_reasons')
"""Those whose rows are made of events, by the last one that has a say in them (`made_of`)."""

_SLOT = 'begin_us, until_us, made_of, version, CAST(slot AS BLOB), checksum'
_STATE = 'seq, now_us, made_of, stays, version, CAST(state AS BLOB), checksum'
"""Read as bytes: damaged ones may not be valid text."""


def keep(database: Database, books: Books) -> None:
    """Write books; a slot takes the place of one that begins at the same moment."""
    slot, state = 'until_us, made_of, version, slot', 'now_us, made_of, stays, version, state'
    _write(database, 'book_slots', 'begin_us', slot, books.slots)
    if books.states:
        database.execute('DELETE FROM book_states WHERE stays = 0')
    _write(database, 'book_states', 'seq', state, books.states)
    _write(database, 'book_scripts', 'digest', 'script', books.scripts)
    _write(database, 'book_reasons', 'made_of', 'reason', books.reasons)


def _write(
    database: Database,
    table: str,
    key: str,
    others: str,
    rows: Sequence[tuple[int | str | bool, ...]],
) -> None:
    replace(database, table, key, f'{others}, checksum', [(*row, _check(row)) for row in rows])


def forget(database: Database, seq: int) -> None:
    """Remove what was made of events after an event."""
    for table in TABLES:
        _try(database, f'DELETE FROM {table} WHERE made_of > ?', seq)


def forget_states(database: Database, before: int) -> None:
    """Remove the states without use, as events after them are gone; but the last.

    :param before: seq of the first event that is kept
    """
    newest = '(SELECT max(seq) FROM book_states)'
    _try(database, f'DELETE FROM book_states WHERE seq < ? AND seq < {newest}', before - 1)


def _try(database: Database, statement: str, seq: int) -> None:
    """Remove rows; damaged books must not keep the node from writing events, or removing them."""
    try:
        database.execute(statement, (seq,))
    except database.Error as error:
        log.warning('some books of the journal cannot be removed (%s)', error)


def reached(database: Database) -> int:
    """Return the seq of the last event that is in books; 0: none is, or it cannot be read."""
    query = 'SELECT coalesce(max(seq), 0) FROM book_states'
    try:
        return int(database.execute(query).fetchone()[0])
    except database.Error as error:
        log.warning('the books of the journal cannot be read (%s)', error)
        return 0


def slots(
    database: Database, begin_us: int, end_us: int, most: int, *, newest_first: bool
) -> SlotPage:
    """Return the slots that lie between two moments, or touch what does."""
    order = 'DESC' if newest_first else 'ASC'
    query = (
        f'SELECT {_SLOT} FROM book_slots WHERE until_us > ? AND begin_us < ? '
        f'AND begin_us >= coalesce((SELECT max(begin_us) FROM book_slots WHERE begin_us <= ?), ?) '
        f'ORDER BY begin_us {order} LIMIT ?'
    )
    values = (begin_us, end_us, begin_us, begin_us, most + 1)
    rows = database.execute(query, values).fetchall()
    kept_slots: list[KeptSlot] = []
    damage: list[Damage] = []
    for begin, until, made_of, version, text, check in rows[:most]:
        slot = KeptSlot(begin, until, made_of, version, text.decode(errors='replace'))
        if check == _check(slot):
            kept_slots.append(slot)
        else:
            damage.append(Damage(f'the account from {_when(slot.begin_us)} on is damaged'))
    return SlotPage(kept_slots, damage, rows[most][0] if rows[most:] else None)


def states(database: Database, at_us: int, first_seq: int) -> KeptState | None:
    """Return the newest sound state that is not after a moment, nor before an event."""
    query = f'SELECT {_STATE} FROM book_states WHERE now_us <= ? AND seq >= ? ORDER BY seq DESC'
    for seq, now_us, made_of, stays, version, text, check in database.execute(
        query, (at_us, first_seq)
    ).fetchall():
        state = KeptState(
            seq, now_us, made_of, bool(stays), version, text.decode(errors='replace')
        )
        if check == _check(state):
            return state
    return None


def script(database: Database, digest: str) -> KeptScript | None:
    """Return a script; None: it is not there, or damaged."""
    query = 'SELECT CAST(script AS BLOB), checksum FROM book_scripts WHERE digest = ?'
    row = database.execute(query, (digest,)).fetchone()
    if row is None:
        return None
    kept_script = KeptScript(digest, row[0].decode(errors='replace'))
    return kept_script if row[1] == _check(kept_script) else None


def reasons(database: Database, after_seq: int, most: int) -> ReasonPage:
    """Return the reasons of stops that were given after an event."""
    query = (
        'SELECT made_of, CAST(reason AS BLOB), checksum FROM book_reasons WHERE made_of > ? '
        'ORDER BY made_of LIMIT ?'
    )
    rows = database.execute(query, (after_seq, most + 1)).fetchall()
    kept_reasons: list[KeptReason] = []
    damage: list[Damage] = []
    for made_of, text, check in rows[:most]:
        reason = KeptReason(made_of, text.decode(errors='replace'))
        if check == _check(reason):
            kept_reasons.append(reason)
        else:
            damage.append(Damage(f'the reason of a stop that event {made_of} gave is damaged'))
    return ReasonPage(kept_reasons, damage, rows[most - 1][0] if rows[most:] else None)


def _check(row: Sequence[int | str | bool]) -> int:
    values = (int(value) if isinstance(value, bool) else value for value in row)
    return check_of(0, '\t'.join(map(str, values)).encode(errors='surrogatepass'))


def _when(us: int) -> str:
    try:
        return f'{datetime.fromtimestamp(us // 1_000_000, timezone.utc):%Y-%m-%d %H:%M} UTC'
    except (OverflowError, ValueError, OSError):
        return 'a moment that is damaged, too,'
