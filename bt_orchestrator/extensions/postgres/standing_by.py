"""A journal in PostgreSQL as a standby sees it, until this standby leads (semantics 9.4)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import psycopg

from bt_orchestrator.base.errors import DatabaseAway, JournalAway, JournalUnusable
from bt_orchestrator.extensions.postgres.connecting import (
    EXAMPLE,
    Connection,
    connected,
    place_of,
)
from bt_orchestrator.extensions.postgres.journal import SETTINGS, PostgresStore, mark_place
from bt_orchestrator.extensions.postgres.leading import WRITING, Looks
from bt_orchestrator.extensions.postgres.schema import (
    JOURNAL,
    LOCK,
    Cell,
    CellTaken,
    cells,
    refuse_kept_otherwise,
    stretches,
)
from bt_orchestrator.extensions.postgres.session import Session
from bt_orchestrator.model.uptime import ClockReading
from bt_orchestrator.ports import Journal, Seen
from bt_orchestrator.store.shared.mark import Mark, Reached

WITHIN_S = 5.0
"""Longest wait for an answer of the server."""


class PostgresStandby:
    """Looks at the journal of a leader, and takes its place. Implements `ports.StandbyJournal`."""

    def __init__(
        self,
        address: str,
        clocks: Callable[[], ClockReading | None],
        marks: Path | None = None,
    ) -> None:
        """Begin without a connection.

        :param address: as in `EXAMPLE`
        :param clocks: reads the clocks of this machine; None: it has no clock that is never set
        :param marks: folder of this machine's marks; None: the usual one
        :raises JournalUnusable: it is no address of a journal
        """
        self._address, self._clocks, self._marks = address, clocks, marks
        self._place = place_of(address)
        if not self._place.cell:
            raise JournalUnusable(f'expected a journal, {EXAMPLE}; found no CELL: {self._place}')
        mark = mark_place(self._place, marks)
        mark.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        self._mark = Mark(mark)
        self._reached = self._mark.found
        self._looks = Looks()
        self._history = ''
        self._cell: Cell | None = None
        self._connection: Connection | None = None
        self._session: Session | None = None

    def look(self) -> Seen:
        """Look at the end of the journal, at the primary.

        :raises JournalAway: it cannot be reached at this moment
        :raises JournalUnusable: no node can go on with it
        """
        with self._speaking():
            session = self._connected()
            if self._cell is None:
                return Seen('', 0, 0, '', is_led=False)
            began = self._clocks()
            row = session.ask(_LOOK, (self._cell.number, LOCK)).fetchone()
        history, epoch, leader, kept_from, seq, time, is_led = row
        seq = seq or kept_from - 1
        self._note(history, seq, time or 0.0, began)
        return Seen(history, seq, epoch, leader, is_led)

    def take(self) -> Journal | None:
        """Become the leader, if the cell has none; None: it has one.

        :raises JournalAway: it cannot be reached at this moment
        :raises JournalUnusable: no node can go on with it
        """
        with self._speaking():
            session = self._connected()
            if self._cell is not None:
                lock = (LOCK, self._cell.number)
                answer = session.ask('SELECT pg_try_advisory_lock($1, $2)', lock)
                if not answer.fetchone()[0]:
                    return None
            self._mark.sync()
            connection, self._connection, self._session = self._connection, None, None
            try:
                return PostgresStore(self._address, self._marks, connection, self._looks)
            except CellTaken:  # two standbys of a new cell at the same moment
                return None

    def close(self) -> None:
        """Close the connection."""
        self._mark.close()
        self._disconnect()

    def _note(self, history: str, seq: int, time: float, began: ClockReading | None) -> None:
        if history != self._history:
            self._history = history
            self._looks.clear()
        if began is not None:
            self._looks.note(seq, began)
        last = self._reached
        if seq and (last is None or last.history != history or last.seq < seq):
            self._reached = Reached(history, seq, time)
            self._mark.write(self._reached)

    @contextmanager
    def _speaking(self) -> Iterator[None]:
        try:
            yield
        except DatabaseAway as error:
            raise JournalAway(str(error)) from error
        except psycopg.OperationalError as error:
            what = ' '.join(str(error).split())
            raise JournalAway(f'the journal {self._place} does not answer: {what}') from error
        except psycopg.Error as error:
            self._disconnect()  # a replica, say, or tables that are being made
            what = ' '.join(str(error).split())
            raise JournalAway(f'the journal {self._place} cannot be looked at: {what}') from error

    def _connected(self) -> Session:
        """Return a session in the tables of the cell, if it has any yet."""
        if self._session is None or self._session.is_broken:
            self._disconnect()
            self._cell = None
            self._connection = connected(self._place, 'standby', (*SETTINGS, *WRITING))
            self._session = Session(self._connection, WITHIN_S)
        assert self._connection is not None
        if self._cell is None:
            self._cell = self._found(self._connection)
        return self._session

    def _found(self, connection: Connection) -> Cell | None:
        """Return the cell and enter its tables; None: the first start is still to come."""
        row = connection.execute("SELECT to_regclass('plant.stretches')").fetchone()
        known = cells(connection) if row and row[0] else []
        cell = next((cell for cell in known if cell.name == self._place.cell), None)
        if cell is None:
            return None
        refuse_kept_otherwise(cell, JOURNAL)
        cell_stretches = stretches(connection, cell)
        if not cell_stretches:
            return None
        connection.execute(f'SET search_path = {cell_stretches[-1].tables}'.encode())
        return cell

    def _disconnect(self) -> None:
        if self._session is not None:
            self._session.close()
        self._connection = self._session = None


_LOOK = """\
WITH seen AS MATERIALIZED (
    SELECT history.id, cells.epoch, cells.holder, history.kept_from, last.seq, last.time, EXISTS (
        SELECT FROM pg_locks WHERE locktype = 'advisory' AND classid = $2 AND objid = $1
        AND database = (SELECT oid FROM pg_database WHERE datname = current_database())
    ) AS is_led
    FROM plant.cells CROSS JOIN history
    LEFT JOIN (SELECT seq, time FROM events ORDER BY seq DESC LIMIT 1) AS last ON true
    WHERE cells.number = $1
)
SELECT seen.* FROM seen, LATERAL pg_logical_emit_message(true, 'bt_orchestrator', '')"""
"""Reads, and commits something afterwards: only a primary that its replicas follow answers.

A primary that others have replaced shows old events for as long as somebody asks it. It cannot
commit, because no replica confirms that to it any more.
"""
