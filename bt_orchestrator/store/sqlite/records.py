"""Reading a journal, with or without a running orchestrator (formats: events)."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from bt_orchestrator.base.errors import DamagedRecord, JournalUnusable
from bt_orchestrator.model.books import KeptScript, KeptState, SlotPage
from bt_orchestrator.model.records import (
    Damage,
    Extent,
    JobPlace,
    RecordPage,
    Summaries,
    Wanted,
)
from bt_orchestrator.ports import Snapshot
from bt_orchestrator.store.sqlite import books, looking, snapshots, summaries
from bt_orchestrator.store.sqlite.checks import check_of_event
from bt_orchestrator.store.sqlite.database import has_log, unchanging, unusable_otherwise
from bt_orchestrator.store.sqlite.mark import mark_of, read_mark
from bt_orchestrator.store.sqlite.schema import history_of, kept_from, schema_of
from bt_orchestrator.store.sqlite.shortfall import cut_off, is_cut_off

_CHECKED = 4
"""First schema with checks of rows."""


class SqliteRecords:
    """A journal file, read-only and without its lock. Implements `ports.Records`."""

    def __init__(self, path: Path) -> None:
        """Open a journal.

        :raises JournalUnusable: it is not there, not ours, newer, or damaged as a whole
        """
        self._path = path
        if not path.is_file():
            raise JournalUnusable(f'there is no journal {path}; check the path')
        with unusable_otherwise(path):
            if not has_log(path):
                with closing(unchanging(path)) as database:
                    schema_of(database, path)
            self._database = _opened(path)
            try:
                self._schema = schema_of(self._database, path)
                self._database.create_function(
                    'check_of_event', 3, check_of_event, deterministic=True
                )
            except BaseException:
                self._database.close()
                raise

    def close(self) -> None:
        """Close the file."""
        self._database.close()

    def extent(self) -> Extent:
        """Return the range of events in it.

        :raises JournalUnusable: it is damaged as a whole
        """
        with self._one_moment():
            return Extent(self._history().id, self._first_seq(), self._last_seq())

    def page(self, wanted: Wanted, most: int = looking.MOST) -> RecordPage:
        """Return the next wanted records.

        :raises JournalUnusable: the file is damaged as a whole
        """
        with self._one_moment():
            history, first, last = self._history(), self._first_seq(), self._last_seq()
            low = max(wanted.after_seq + 1, first)
            high = last if wanted.before_seq is None else min(wanted.before_seq - 1, last)
            look = looking.Look(wanted, low, high, most)
            look.through(self._database, _sound(self._schema, history.checked_from))
        damage = [*history.damage, *map(self._left_out, look.damaged)]
        if high >= last if wanted.newest_first else look.is_last:
            damage += self._gone(history.id)
        return RecordPage(history.id, first, look.found, damage, look.rest, look.is_last)

    def summaries(
        self,
        after: JobPlace | None = None,
        most: int = looking.MOST,
        *,
        newest_first: bool = False,
    ) -> Summaries:
        """Return the summaries of jobs that ended.

        :raises JournalUnusable: the file is damaged as a whole
        """
        if self._schema < _HAS_SUMMARIES:
            return Summaries((), (), None)
        with unusable_otherwise(self._path):
            found = summaries.page(
                self._database,
                after,
                max(1, min(most, looking.MOST)),
                newest_first=newest_first,
                has_checks=self._schema >= _CHECKED,
            )
        where = f'in the journal {self._path}'
        damage = [one._replace(what=f'{one.what} {where}') for one in found.damage]
        return replace(found, damage=damage)

    def state_before(self, seq: int) -> Snapshot | None:
        """Return the newest sound state at an event or before it; None: there is none.

        :raises JournalUnusable: the file is damaged as a whole
        """
        if self._schema < _HAS_SUMMARIES:
            return None
        with unusable_otherwise(self._path):
            return snapshots.state_before(self._database, seq)

    def booked(
        self,
        begin_us: int,
        end_us: int,
        most: int = looking.MOST,
        *,
        newest_first: bool = False,
    ) -> SlotPage:
        """Return the slots of the account that lie between two moments, or touch what does.

        :raises JournalUnusable: the file is damaged as a whole
        """
        if self._schema < _HAS_BOOKS:
            return SlotPage((), (), None)
        most = max(1, min(most, looking.MOST))
        with unusable_otherwise(self._path):
            found = books.slots(self._database, begin_us, end_us, most, newest_first=newest_first)
        where = f'in the journal {self._path}'
        return replace(found, damage=[Damage(f'{one.what} {where}') for one in found.damage])

    def book_state(self, at_us: int, first_seq: int = 0) -> KeptState | None:
        """Return the newest sound state of the account that is not after a moment.

        :raises JournalUnusable: the file is damaged as a whole
        """
        if self._schema < _HAS_BOOKS:
            return None
        with unusable_otherwise(self._path):
            return books.states(self._database, at_us, first_seq)

    def book_script(self, digest: str) -> KeptScript | None:
        """Return a script whose work is in the journal; None: it is missing, or damaged.

        :raises JournalUnusable: the file is damaged as a whole
        """
        if self._schema < _HAS_BOOKS:
            return None
        with unusable_otherwise(self._path):
            return books.script(self._database, digest)

    # --- its own data -----------------------------------------------------------------------

    def _history(self) -> _Known:
        if self._schema < _CHECKED:
            return _Known('', 0, [])
        try:
            found = history_of(self._database)
        except ValueError as error:
            what = f'{error} in the journal {self._path}: no node will start with it'
            return _Known('', 0, [Damage(what)])
        return _Known(found.id, found.checked_from, [])

    def _first_seq(self) -> int:
        if self._schema >= _CHECKED:
            return kept_from(self._database)
        return self._number('SELECT coalesce(min(seq), 1) FROM events')

    def _last_seq(self) -> int:
        return self._number('SELECT coalesce(max(seq), 0) FROM events')

    def _number(self, query: str) -> int:
        return int(self._database.execute(query).fetchone()[0])

    # --- missing data -----------------------------------------------------------------------

    def _left_out(self, damaged: DamagedRecord) -> Damage:
        return Damage(
            f'{damaged} in the journal {self._path}, and left out here; a backup may have what it '
            'was',
            damaged.last + 1 - damaged.first,
        )

    def _gone(self, history: str) -> Iterator[Damage]:
        """Compare the end with the mark, which is written after each commit."""
        reached = read_mark(mark_of(self._path))
        if reached is None:
            yield from self._cut_off()
            return
        if reached.history != history:
            return
        with self._one_moment():
            replayed = 'SELECT coalesce(max(seq), 0) FROM beginning'
            last = max(self._last_seq(), self._number(replayed))
        if reached.seq > last:
            yield Damage(
                f'the journal {self._path} ends with event {last}, and event {reached.seq} had '
                'been written: what is between is not in it any more',
                reached.seq - last,
            )

    def _cut_off(self) -> Iterator[Damage]:
        """Report that the journal may be incomplete; how much is missing is unknown."""
        with unusable_otherwise(self._path):
            if self._schema >= _SAYS_CLOSED and is_cut_off(self._database, self._path):
                what = cut_off(self._path, self._last_seq())
                yield Damage(f'the journal {self._path} may be a part of one: {what}', 0)

    @contextmanager
    def _one_moment(self) -> Iterator[None]:
        """Read the journal in its present state, unaffected by later writes."""
        with unusable_otherwise(self._path):
            self._database.execute('BEGIN')
            try:
                yield
            finally:
                self._database.rollback()


_SAYS_CLOSED = 5
"""First schema in which a file says whether it was closed."""


class _Known(NamedTuple):
    """The data of the history row."""

    id: str
    checked_from: int
    """All events from this one on have a check."""
    damage: list[Damage]


_HAS_BOOKS = 6
"""First schema with books."""

_HAS_SUMMARIES = 2
"""First schema with states, and with summaries of jobs that ended."""


def _sound(schema: int, checked_from: int) -> str:
    """Return the SQL condition for an undamaged record."""
    if schema < _CHECKED:
        return 'json_valid(record)'
    return (
        f'CASE WHEN checksum IS NULL THEN seq < {checked_from} AND json_valid(record) '
        'ELSE checksum = check_of_event(seq, CAST(record AS BLOB), coalesce(ends, 0)) END'
    )


def _opened(path: Path) -> sqlite3.Connection:
    """Open a file for reading.

    SQLite creates files beside a journal even to read it. If it may not, and no writer has left
    any, the file is opened as immutable.
    """
    uri = f'{path.resolve().as_uri()}?mode=ro'
    database = sqlite3.connect(uri, uri=True, timeout=10.0, isolation_level=None)
    try:
        database.execute('SELECT 1 FROM sqlite_schema').fetchone()
    except sqlite3.OperationalError:
        database.close()
        if path.with_name(path.name + '-wal').exists():
            raise
        return sqlite3.connect(f'{uri}&immutable=1', uri=True, isolation_level=None)
    return database
