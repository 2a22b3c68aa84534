"""Reading the journal of a cell in a database, with or without a running orchestrator."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from bt_orchestrator.base.errors import DamagedRecord, JournalUnusable
from bt_orchestrator.extensions.postgres.connecting import connected, place_of, speaking_of
from bt_orchestrator.extensions.postgres.journal import mark_place
from bt_orchestrator.extensions.postgres.schema import (
    FEED,
    Gap,
    Stretch,
    cell_named,
    check_of_row,
    stretches,
)
from bt_orchestrator.extensions.postgres.session import Session
from bt_orchestrator.model.keeping.books import ReasonPage
from bt_orchestrator.model.keeping.records import Damage
from bt_orchestrator.store.shared.database import Database, History
from bt_orchestrator.store.shared.mark import Reached, mark_of, read_mark
from bt_orchestrator.store.shared.records import KeptRecords
from bt_orchestrator.store.shared.rows import MOST, Terms

WITHIN_S = 30.0
"""Longest wait for the answer to one query."""

_SETTINGS = (f'SET statement_timeout = {int(WITHIN_S * 1000)}',)


class PostgresRecords(KeptRecords):
    """The tables of a cell, read-only and without its lock. Implements `ports.Records`.

    A copy that a feed made has the events of a history and of those that it goes on from, in
    tables of their own; a view of this session puts them together.
    """

    _terms = Terms(
        'job = ?',
        'time >= ?',
        'time <= ?',
        r"event LIKE replace(replace(?, '_', '\_'), '*', '%')",
        check=check_of_row,
    )

    def __init__(self, address: str, marks: Path | None = None) -> None:
        """Open the journal of a cell.

        :param marks: folder of this machine's marks; None: the usual one
        :raises JournalUnusable: it is not there, or newer
        """
        self._place = place_of(address)
        self._name = str(self._place)
        self._mark = mark_of(mark_place(self._place, marks))
        self._copy: Copy | None = None
        self._session = self._opened()

    def _opened(self) -> Session:
        connection = connected(self._place, 'reader', _SETTINGS)
        try:
            with speaking_of(self._place):
                cell = cell_named(connection, self._place)
                known = {stretch.history: stretch for stretch in stretches(connection, cell)}
                current = known.get(cell.history)
                if current is None:
                    raise JournalUnusable(
                        f'the cell {cell.name} has no events yet: its feed has not begun'
                    )
                if cell.kept_by == FEED:
                    self._copy = Copy(current.history, list(lineage(current, known)))
                    for statement in self._copy.views():
                        connection.execute(statement.encode())
                connection.execute(f'SET search_path = pg_temp, {current.tables}'.encode())
        except BaseException:
            connection.close()
            raise
        return Session(connection, WITHIN_S)

    def close(self) -> None:
        """Close the connection."""
        self._session.close()

    def _has_another_history(self) -> bool:
        """Tell whether a feed has begun another history since this was opened."""
        if self._copy is None:
            return False
        with speaking_of(self._place):
            query = 'SELECT history FROM plant.cells WHERE cell = $1'
            row = self._session.ask(query, (self._place.cell,)).fetchone()
        return row is None or row[0] != self._copy.history

    def book_reasons(self, after_seq: int = 0, most: int = MOST) -> ReasonPage:
        """Return the reasons of stops; none where no program of today has written.

        :raises JournalUnusable: it cannot be read
        """
        with self._one_moment() as database:
            (table,) = database.execute("SELECT to_regclass('book_reasons')").fetchone()
        return ReasonPage((), (), None) if table is None else super().book_reasons(after_seq, most)

    def _reached(self) -> Reached | None:
        return read_mark(self._mark) if self._copy is None else None

    def _history(self, database: Database) -> tuple[History, list[Damage]]:
        if self._copy is None:
            return super()._history(database)
        return History(self._copy.history, False), []

    def _ends(self, database: Database) -> tuple[int, int]:
        if self._copy is None:
            return super()._ends(database)
        query = (
            'SELECT (SELECT max(last_seq) + 1 FROM gaps WHERE first_seq = 1 AND why = ?), '
            '(SELECT greatest((SELECT max(seq) FROM events), (SELECT max(last_seq) FROM gaps)))'
        )
        first, last = database.execute(query, ('removed',)).fetchone()
        return first or 1, last or 0

    def _left_out(self, damaged: DamagedRecord) -> Damage:
        """Tell of events that never came in other words than of those that are damaged here."""
        if self._copy is not None:
            query = 'SELECT why FROM gaps WHERE first_seq <= ? AND last_seq >= ?'
            with self._one_moment() as database:
                row = database.execute(query, (damaged.first, damaged.last)).fetchone()
            if row is not None:
                gap = Gap(damaged.first, damaged.last, row[0])
                return Damage(f'{self._name}: {gap}', damaged.last + 1 - damaged.first)
        return super()._left_out(damaged)

    @contextmanager
    def _one_moment(self) -> Iterator[Session]:
        if self._session.is_broken or self._has_another_history():
            self._session.close()
            self._session = self._opened()
        session = self._session
        with speaking_of(self._place):
            session.ask('BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY')
            try:
                yield session
            finally:
                if not session.is_broken:
                    session.ask('ROLLBACK')


class Copy(NamedTuple):
    """A copy that a feed made."""

    history: str
    """Of the journal, as last copied."""
    parts: Sequence[tuple[str, int | None]]
    """The tables that have its events, newest first, and the last event that is wanted of them."""

    def views(self) -> Iterator[str]:
        """Yield the statements that make one table of each kind of them, for this session."""
        for table, seq in (('events', 'seq'), ('gaps', 'first_seq')):
            queries = (
                f'SELECT * FROM {tables}.{table}'
                + ('' if last is None else f' WHERE {seq} <= {last}')
                for tables, last in self.parts
            )
            yield f'CREATE TEMPORARY VIEW {table} AS ' + ' UNION ALL '.join(queries)


def lineage(stretch: Stretch, known: Mapping[str, Stretch]) -> Iterator[tuple[str, int | None]]:
    """Yield a stretch and those that it goes on from, with the last event that counts of each."""
    by_number = {other.number: other for other in known.values()}
    last: int | None = None
    while True:
        yield stretch.tables, last
        if stretch.parent is None:
            return
        before = stretch.first_seq - 1
        last = before if last is None else min(before, last)
        stretch = by_number[stretch.parent]
