"""Copies the journal of a cell into a plant's database: in order, each event once, resumable.

The place that was reached is in the database, in the transaction of the events themselves. So a
feed that is killed goes on where it was, and so does one whose database was restored.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple, Protocol

from bt_orchestrator.base.errors import JournalUnusable
from bt_orchestrator.extensions.postgres.connecting import Connection
from bt_orchestrator.extensions.postgres.schema import (
    Cell,
    Gap,
    Stretch,
    begin_stretch,
    check_of_event,
    stretches,
)
from bt_orchestrator.model.events import JobQueued
from bt_orchestrator.model.keeping.records import Extent, Record
from bt_orchestrator.store.sqlite.copying import TABLES, Key, Table, changed, side_tables


class Batch(NamedTuple):
    """Some consecutive records of a journal."""

    history: str
    """Of the journal at this moment."""
    records: Sequence[Record]
    reached: int
    """There is nothing more between them and up to this event."""
    first_seq: int
    """Earlier ones were removed."""
    is_last: bool


class Source(Protocol):
    """A journal from which a feed copies."""

    def extent(self) -> Extent:
        """Return the history and the range of its events."""

    def after(self, seq: int) -> Batch:
        """Return the next records after an event."""

    def starts(self) -> Iterator[tuple[int, str]]:
        """Yield each start of a node: the number of its event, and the history that it names."""


@dataclass
class Copied:
    """The work of one turn of a feed."""

    events: int = 0
    rows: int = 0
    """Of the other tables."""
    gaps: list[Gap] = field(default_factory=list)


class _Part(NamedTuple):
    """The events of a journal that are of one history."""

    history: str
    first: int
    last: int | None
    """None: it goes on."""


class Feed:
    """Writes one cell of a plant."""

    def __init__(self, connection: Connection, cell: Cell) -> None:
        """Begin.

        :param connection: has the lock of the cell
        """
        self._connection = connection
        self._cell = cell
        self._source: Source | None = None
        self._history = ''
        """Of the journal, at the beginning of this turn."""
        self._current: Stretch | None = None
        self._reached = 0
        self._known: dict[tuple[int, str], dict[Key, object]] = {}
        """Checks of the rows in the database, by the number of the stretch and the table."""

    @property
    def reached(self) -> int:
        """The last event that was copied, of the present history."""
        return self._reached

    def copy_events(self, source: Source) -> Copied:
        """Copy all events that are new.

        :raises JournalUnusable: the journal cannot be read, or contradicts what was copied of it
        """
        done, extent = Copied(), source.extent()
        if not extent.history:
            raise JournalUnusable(
                'the journal has no name for its history: an older program wrote it. Start a node '
                'of this version on it once'
            )
        self._history = extent.history
        current = self._current
        if current is None or source is not self._source or current.history != extent.history:
            self._current = None
            current = self._come_to(source, extent, done)
            self._source = source
        if self._reached > max(extent.last_seq, extent.first_seq - 1):
            raise JournalUnusable(
                f'the journal ends with event {extent.last_seq}, and event {self._reached} of the '
                'same history was copied: its end is lost, or older files took its place. Nothing '
                'is copied until a node has begun a new history on it'
            )
        self._reached = self._copy(source, current, None, done)
        return done

    def copy_tables(self, path: Path, done: Copied) -> None:
        """Copy what is new or changed in the other tables of a journal file."""
        assert self._current is not None
        with side_tables(path) as tables:
            if tables is None or tables.history != self._current.history:
                return
            for table in TABLES:
                now = tables.checks(table)
                before = self._checks(self._current, table)
                keys = changed(now, before)
                gone = [key for key in before if key not in now] if table.is_mirrored else []
                if keys or gone:
                    with self._connection.transaction():
                        self._remove(self._current, table, gone)
                        self._write_rows(self._current, table, list(tables.rows(table, keys)))
                    self._known[self._current.number, table.name] = now
                    done.rows += len(keys)

    def is_complete(self) -> None:
        """Note that nothing is missing at this moment."""
        self._connection.execute(
            'UPDATE plant.cells SET complete_at = now() WHERE number = %s', (self._cell.number,)
        )

    # --- histories --------------------------------------------------------------------------

    def _come_to(self, source: Source, extent: Extent, done: Copied) -> Stretch:
        """Let the history of the journal be the present one.

        The first time, the histories from which it goes on come first: each has the events that
        are its own, and those that were copied before are not copied again.
        """
        known = {stretch.history: stretch for stretch in stretches(self._connection, self._cell)}
        current = known.get(extent.history)
        if current is None:
            parent: Stretch | None = None
            for history, first, last in self._parts(source, extent, known):
                current = known.get(history) or begin_stretch(
                    self._connection, self._cell, history, parent, first
                )
                if last is not None:
                    self._copy(source, current, last, done)
                parent = current
        assert current is not None
        self._refuse_others(source, current)
        self._connection.execute(
            'UPDATE plant.cells SET history = %s WHERE number = %s',
            (extent.history, self._cell.number),
        )
        self._current, self._reached = current, self._reached_in(current)
        return current

    def _parts(self, source: Source, extent: Extent, known: dict[str, Stretch]) -> Iterator[_Part]:
        """Yield the histories of a journal, oldest first: a node that starts names its own."""
        named: list[tuple[int, str]] = []
        for seq, history in source.starts():
            if history and history not in (name for _, name in named):
                named.append((seq, history))
        if not named:
            named = [(1, extent.history)]
        elif named[-1][1] != extent.history:  # it was restored, and no node has started yet
            named.append((extent.last_seq + 1, extent.history))
        if named[0][0] > extent.first_seq and (before := self._found(source, extent, known)):
            named = [(extent.first_seq, before), *(entry for entry in named if entry[1] != before)]
        ends: list[int | None] = [seq - 1 for seq, _ in named[1:]]
        for number, ((seq, history), last) in enumerate(zip(named, [*ends, None], strict=True)):
            yield _Part(history, seq if number else 1, last)

    def _found(self, source: Source, extent: Extent, known: dict[str, Stretch]) -> str:
        """Return the history whose copy has the first event of a journal; empty: none has."""
        record = next(iter(source.after(extent.first_seq - 1).records), None)
        for stretch in reversed(known.values()):
            if record is not None and self._text(stretch, record.seq) == record.text:
                return stretch.history
        return ''

    def _refuse_others(self, source: Source, stretch: Stretch) -> None:
        """Compare the last event that was copied.

        :raises JournalUnusable: the journal has another one under its number
        """
        reached = self._reached_in(stretch)
        if not reached:
            return
        record = next(iter(source.after(reached - 1).records), None)
        text = self._text(stretch, reached)
        if record is not None and record.seq == reached and text not in (None, record.text):
            raise JournalUnusable(
                f'event {reached} of the journal is not the one that was copied under this number '
                'and history: other files took its place. Restore a backup with '
                '`bt-orchestrator journal restore`, which begins a new history'
            )

    # --- rows -------------------------------------------------------------------------------

    def _copy(self, source: Source, stretch: Stretch, last: int | None, done: Copied) -> int:
        """Copy what is new up to an event; returns the last event that is there."""
        at = self._reached_in(stretch)
        while last is None or at < last:
            batch = source.after(at)
            reached = batch.reached if last is None else min(batch.reached, last)
            if batch.history != self._history:
                break  # a node has begun another one meanwhile: that is the next turn's
            if reached > at:
                records = [record for record in batch.records if record.seq <= reached]
                gaps = list(_gaps(at, reached, records, batch.first_seq))
                with self._connection.transaction():
                    self._write_events(stretch, records, gaps)
                at = reached
                done.events += len(records)
                done.gaps += gaps
            if batch.is_last:
                break
        return at

    def _reached_in(self, stretch: Stretch) -> int:
        row = self._connection.execute(
            stretch.sql(
                'SELECT greatest((SELECT max(seq) FROM {stretch}.events), '
                '(SELECT max(last_seq) FROM {stretch}.gaps))'
            )
        ).fetchone()
        assert row is not None
        return stretch.first_seq - 1 if row[0] is None else int(str(row[0]))

    def _text(self, stretch: Stretch, seq: int) -> str | None:
        query = stretch.sql('SELECT record FROM {stretch}.events WHERE seq = %s')
        row = self._connection.execute(query, (seq,)).fetchone()
        return None if row is None else str(row[0])

    def _write_events(
        self, stretch: Stretch, records: Sequence[Record], gaps: Sequence[Gap]
    ) -> None:
        queued: list[tuple[int, str]] = []
        with self._connection.cursor() as cursor:
            statement = (
                'COPY {stretch}.events (seq, record, checksum, event, job, time) FROM STDIN'
            )
            with cursor.copy(stretch.sql(statement)) as copy:
                for seq, text in records:
                    record = json.loads(text)
                    job, event = record.get('job'), str(record['event'])
                    job = None if job is None else _plain(str(job))
                    check = check_of_event(seq, text, 0)
                    copy.write_row((seq, text, check, _plain(event), job, record['time']))
                    if event == JobQueued.event and job is not None:
                        queued.append((seq, job))
            cursor.executemany(stretch.sql('INSERT INTO {stretch}.queued VALUES (%s, %s)'), queued)
            cursor.executemany(
                stretch.sql(
                    'INSERT INTO {stretch}.gaps (first_seq, last_seq, why) VALUES (%s, %s, %s)'
                ),
                gaps,
            )

    def _checks(self, stretch: Stretch, table: Table) -> dict[Key, object]:
        known = self._known.get((stretch.number, table.name))
        if known is None:
            names = ', '.join((*table.keys, table.check))
            rows = self._connection.execute(
                stretch.sql(f'SELECT {names} FROM {{stretch}}.{table.name}')
            )
            known = {tuple(row[:-1]): row[-1] for row in rows}
        return known

    def _remove(self, stretch: Stretch, table: Table, keys: Sequence[Key]) -> None:
        where = ' AND '.join(f'{name} = %s' for name in table.keys)
        with self._connection.cursor() as cursor:
            cursor.executemany(
                stretch.sql(f'DELETE FROM {{stretch}}.{table.name} WHERE {where}'), keys
            )

    def _write_rows(
        self, stretch: Stretch, table: Table, rows: Sequence[Sequence[object]]
    ) -> None:
        instead = ', '.join(f'{name} = excluded.{name}' for name in table.others)
        statement = (
            f'INSERT INTO {{stretch}}.{table.name} ({", ".join(table.columns)}) '
            f'VALUES ({", ".join(["%s"] * len(table.columns))}) '
            f'ON CONFLICT ({", ".join(table.keys)}) DO UPDATE SET {instead}'
        )
        with self._connection.cursor() as cursor:
            cursor.executemany(stretch.sql(statement), rows)


def _gaps(at: int, reached: int, records: Sequence[Record], first_seq: int) -> Iterator[Gap]:
    """Yield what is missing after an event and up to another one."""
    for seq in (*(record.seq for record in records), reached + 1):
        removed, last = min(seq, first_seq) - 1, seq - 1
        if at < removed:
            yield Gap(at + 1, removed, 'removed')
        if max(at, removed) < last:
            yield Gap(max(at, removed) + 1, last, 'damaged')
        at = seq


def _plain(text: str) -> str:
    """Return a text that PostgreSQL takes as a column; the record has the original."""
    return text.encode(errors='replace').decode().replace('\x00', '�')
