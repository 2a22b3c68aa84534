"""Copying a whole journal into an empty one, of any store, as a history of its own (9.2)."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple
from uuid import uuid4

from bt_orchestrator.base.errors import JournalFailed, JournalUnusable
from bt_orchestrator.store.shared import rows
from bt_orchestrator.store.shared.database import Check, Database, keep_from, kept_from
from bt_orchestrator.store.shared.journal import EVERY, KeptJournal
from bt_orchestrator.store.shared.mark import Reached

Columns = Sequence[tuple[str, Sequence[str]]]
"""Tables with their columns."""


PATIENCE_S = 3600.0
"""Longest time that all of a copy may take."""


class Copied(NamedTuple):
    """A copy whose rows were compared with those of the journal."""

    history: str
    last_seq: int
    events: int
    rows: int
    """Of the other tables."""
    digest: str
    """SHA-256 of the events."""


def copy_journal(source: KeptJournal, target: KeptJournal, tables: Columns) -> Copied:
    """Copy a journal; if this fails, the target is as empty as it was.

    :param tables: those besides the events, each with all its columns
    :raises JournalUnusable: something is missing in the source, or the target is not empty
    :raises JournalFailed: the target cannot be written, or what is read there differs
    """
    with target.looking() as made:
        if rows.last_seq(made) or kept_from(made) > 1:
            raise JournalUnusable('there are events in the journal to be; name an empty one')
    with source.looking() as original:
        last = rows.last_seq(original)
        if what := source.missing(last):
            raise JournalUnusable(f'{what}. Start a node on it, which begins a new history')
        number, digest = _digest(original, source.check)
    history = uuid4().hex
    target.patience_s = PATIENCE_S
    with source.looking() as original, target.writing() as made:
        target.name_history(made, history, restored=True)
        keep_from(made, kept_from(original))
        for page in _pages(original, source.check):
            target.take(made, page)
        for name, columns in tables:
            marks = ', '.join('?' * len(columns))
            into = f'INSERT INTO {name} ({", ".join(columns)}) VALUES ({marks})'
            made.executemany(into, _rows_of(original, name, columns))
        if (number, digest) != _digest(made, target.check):
            raise JournalFailed('the events that are read from the copy are not those written')
        others = 0
        for name, columns in tables:
            before, after = (
                sorted(_rows_of(database, name, columns)) for database in (original, made)
            )
            if before != after:
                raise JournalFailed(f'the table {name} of the copy is not what was written')
            others += len(before)
        time = _time_of(made, last)
    target.note(Reached(history, last, time))
    return Copied(history, last, number, others, digest)


def _pages(database: Database, check: Check) -> Iterator[Sequence[rows.Row]]:
    """Yield all rows of events.

    :raises JournalUnusable: one is damaged, or missing
    """
    after = kept_from(database) - 1
    while page := rows.page(database, after, EVERY, -1):
        for row in page:
            if row.seq != after + 1 or not row.is_sound(EVERY, check):
                raise JournalUnusable(
                    f'event {after + 1} is damaged or missing. Start a node on the journal, which '
                    'begins a new history without it'
                )
            after = row.seq
        yield page


def _digest(database: Database, check: Check) -> tuple[int, str]:
    number, digest = 0, hashlib.sha256()
    for page in _pages(database, check):
        number += len(page)
        for row in page:
            digest.update(b'%d %d %s\n' % (row.seq, 1 if row.ends is None else row.ends, row.text))
    return number, digest.hexdigest()


def _rows_of(database: Database, name: str, columns: Sequence[str]) -> list[tuple[Any, ...]]:
    query = f'SELECT {", ".join(columns)} FROM {name}'
    return [tuple(row) for row in database.execute(query).fetchall()]


def _time_of(database: Database, seq: int) -> float:
    """Return when an event happened; 0: it was removed."""
    page = rows.page(database, seq - 1, seq, 1)
    return float(json.loads(page[0].text)['time']) if page else 0.0
