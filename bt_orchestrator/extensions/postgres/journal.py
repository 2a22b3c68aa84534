"""The durable journal: the tables of a cell in PostgreSQL (semantics 9.1)."""

from __future__ import annotations

import json
import logging
import os
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from datetime import datetime, timezone
from pathlib import Path
from socket import gethostname
from typing import Any, NamedTuple
from urllib.parse import quote
from uuid import uuid4

import psycopg
from psycopg.conninfo import conninfo_to_dict

from bt_orchestrator.base.errors import DatabaseAway, JournalFailed, JournalUnusable
from bt_orchestrator.extensions.postgres.connecting import (
    EXAMPLE,
    Connection,
    Place,
    connected,
    place_of,
)
from bt_orchestrator.extensions.postgres.leading import (
    ABIDING,
    GUARD_S,
    RENEW_S,
    WRITING,
    Lease,
    Looks,
    now_s,
)
from bt_orchestrator.extensions.postgres.schema import (
    JOURNAL,
    LOCK,
    begin_stretch,
    check_of_event,
    check_of_row,
    enter,
    stretches,
)
from bt_orchestrator.extensions.postgres.session import NotOnReplicas, Session, array_of
from bt_orchestrator.model.codec import to_text
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.uptime import ClockReading
from bt_orchestrator.store.sequence import refuse_gap
from bt_orchestrator.store.shared import rows
from bt_orchestrator.store.shared.database import Database, history_of, kept_from, seal
from bt_orchestrator.store.shared.journal import EVERY, KeptJournal
from bt_orchestrator.store.shared.mark import Mark, Reached

log = logging.getLogger(__name__)

PATIENCE_S = 4.0
"""How long a write tries to reach the server again before it has failed."""

STARTING_S = 60.0
"""Longest wait for an answer to what is read before the first append: nothing runs yet."""

RUNNING_S = 2.0
"""The same afterwards: the cell does not wait meanwhile, and its clients do."""

AGAIN_S = 0.05
"""Time between two attempts to reach the server."""

SETTINGS = ('SET synchronous_commit = on', 'SET idle_in_transaction_session_timeout = 10000')

_GONE = (psycopg.OperationalError, psycopg.errors.ReadOnlySqlTransaction, DatabaseAway)
"""Errors after which the same may succeed with another connection."""


class AnotherWriter(psycopg.DatabaseError):  # type: ignore[misc]
    """Another orchestrator has taken over the cell: its epoch is higher."""


class PostgresStore(KeptJournal):
    """A journal in a database that several machines can reach. Implements `ports.Journal`.

    An advisory lock keeps a second orchestrator out for as long as the server sees this one.
    Whoever opens the journal raises the epoch of the cell, and every write compares it, so one
    that has lost the lock writes nothing any more.
    """

    is_shared = True
    check = staticmethod(check_of_row)
    _reading: Session

    def __init__(
        self,
        address: str,
        marks: Path | None = None,
        connection: Connection | None = None,
        looks: Looks | None = None,
    ) -> None:
        """Open or create a journal.

        :param address: as in `EXAMPLE`
        :param marks: folder of this machine's marks; None: the usual one
        :param connection: one that has the lock of the cell already; None: none has
        :param looks: what this machine has seen of it before; None: nothing
        :raises CellTaken: another node or a feed has it
        :raises JournalUnusable: it is a copy, newer, damaged, or cannot be reached
        """
        self._place = place_of(address)
        if not self._place.cell:
            raise JournalUnusable(f'expected a journal, {EXAMPLE}; found no CELL: {self._place}')
        mark = mark_place(self._place, marks)
        mark.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        super().__init__(Mark(mark))
        self.patience_s = PATIENCE_S
        """How long a write may take."""
        self._floor: int | None = None
        """The last event that has a row, or was removed by retention; None: not looked up."""
        self._is_running = False
        self._lease, self._looks = Lease(), looks or Looks()
        connection = connection or self._connected(STARTING_S, WRITING)
        self._writer = Session(connection, STARTING_S)
        try:
            with self._usable():
                self._begin(connection)
                self._reading = self._reader()
        except BaseException:
            self._writer.close()
            raise

    def _begin(self, connection: Connection) -> None:
        """Become the writer; what can be read afterwards is on the replicas as well."""
        holder = f'{gethostname()}, process {os.getpid()}'
        self._cell = cell = enter(connection, self._place.cell, JOURNAL, holder)
        self.epoch = cell.epoch
        cell_stretches = stretches(connection, cell)
        history = uuid4().hex
        self._tables = (
            cell_stretches[-1] if cell_stretches else begin_stretch(connection, cell, history)
        ).tables
        self._enter_tables(self._writer)
        if not cell_stretches:
            self._writer.ask('INSERT INTO history (one, id) VALUES (1, $1)', (history,))
            seal(self._writer)
        self._history = self._on_file = history_of(self._writer)
        self.alone_from_s = time.monotonic() + GUARD_S
        self._checks_after(self._writer, EVERY)

    # --- events -----------------------------------------------------------------------------

    def append(self, events: Sequence[Event]) -> None:
        """Make the events durable, all or none.

        :raises JournalFailed: none of them is durable, or that is not known
        """
        until = time.monotonic() + self.patience_s
        with self._failing():
            self._append(events, until)
        self._last = self._floor = events[-1].seq
        if not self._is_running:
            self._is_running = True
            self._reading.within_s = RUNNING_S
            self._abide(self._writer)
        self._mark.write(Reached(self.history, events[-1].seq, events[-1].time))

    def _append(self, events: Sequence[Event], until: float) -> None:
        last, columns = self._last, _columns(_new_rows(events))

        def write(session: Session, is_unknown: bool) -> None:
            nonlocal last
            if last is None:
                last = self._followed_by(session, events[0].seq)
            refuse_gap(events, last)
            if not (is_unknown and self._are_kept(session, last, columns)):
                self.at_disk()
                self._write(session, columns)

        self._persist(until, write)

    def _persist(self, until: float, write: Callable[[Session, bool], object]) -> None:
        """Write something, and again with another connection when one breaks.

        :param write: is told whether an answer was lost: then it may be written already
        """
        is_unknown = False
        while True:
            try:
                write(self._session(until), is_unknown)
                return
            except NotOnReplicas:
                raise
            except _GONE as error:
                if time.monotonic() + AGAIN_S >= until:
                    raise
                log.warning('the journal %s is asked again: %s', self._place, error)
                is_unknown = True
                time.sleep(AGAIN_S)

    # --- leading ----------------------------------------------------------------------------

    def may_command(self) -> bool:
        """Tell whether a goal may be sent at this moment."""
        return self._lease.holds

    def absent_at(self, seq: int) -> ClockReading | None:
        """Return when this machine last looked before an event was there; None: not known."""
        return self._looks.absent_at(seq)

    def renew(self) -> None:
        """Check that this is still the writer.

        :raises JournalFailed: it is not, or that is not known
        """
        if self._lease.age_s >= RENEW_S:
            until = time.monotonic() + self.patience_s
            with self._failing():
                self._persist(until, lambda session, _: self._checks_after(session, EVERY))

    def _abide(self, session: Session) -> None:
        """Let the server end the session soon if this node falls silent."""
        with suppress(*_GONE):  # the next one is told as well
            session.ask(ABIDING)

    def _are_kept(self, session: Session, last: int, columns: Sequence[str]) -> bool:
        """Tell whether events are there, whose commit was not answered.

        :param last: the event before them
        :raises JournalFailed: other ones are
        """
        checks = self._checks_after(session, last)
        if history_of(session).id != self.history:
            return False
        if checks and array_of(checks) != columns[_CHECKS]:
            raise JournalFailed(f'other events than its own follow event {last}')
        if checks:
            self._on_file, self._end = self._history, EVERY
        return bool(checks)

    def _checks_after(self, session: Session, seq: int) -> list[int]:
        """Return the checks of the events after one.

        A replica need not have rows that are seen here, after a crash say. So this commits
        something after them, and waits for the replicas.

        :raises AnotherWriter: this is no writer any more
        """
        began_s = now_s()
        row = session.ask(
            'WITH seen AS MATERIALIZED (SELECT seq, checksum FROM events WHERE seq > $3) '
            'UPDATE plant.cells SET since = since WHERE number = $1 AND epoch = $2 '
            'RETURNING (SELECT array_agg(checksum ORDER BY seq) FROM seen)',
            (self._cell.number, self._cell.epoch, seq),
        ).fetchone()
        if row is None:
            raise AnotherWriter(_TAKEN_OVER)
        self._lease.confirm(began_s)
        return row[0] or []

    def _write(self, session: Session, columns: Sequence[str]) -> None:
        began_s = now_s()
        self._write_rows(session, columns)
        self._lease.confirm(began_s)

    def _write_rows(self, session: Session, columns: Sequence[str]) -> None:
        if self._history != self._on_file:
            with self._transaction(session):
                self._set_aside(session)
                rows.remove_after(session, self._end)
                self.name_history(session, self.history)
                self._insert(session, columns, _floor_of(session))
            self._on_file, self._end = self._history, EVERY
            return
        if self._floor is None:
            self._floor = _floor_of(session)
        self._insert(session, columns, self._floor)

    def _insert(self, session: Session, columns: Sequence[str], floor: int) -> None:
        values = (*columns, self._cell.number, self._cell.epoch, floor)
        if not session.ask(_APPEND, values, often=True).fetchone()[0]:
            self._refuse_another(session)
            raise JournalFailed(
                f'the last event is {_floor_of(session)} and not {floor}: another program '
                'changes the tables'
            )

    def _set_aside(self, session: Session) -> None:
        """Keep the events that the next history takes the place of, under another name."""
        if rows.last_seq(session) > self._end:
            now = datetime.now(timezone.utc)
            aside = f'{self._tables}.events_aside_{now:%Y%m%dT%H%M%SZ}'.lower()
            session.ask(f'CREATE TABLE {aside} AS SELECT * FROM events')
            log.warning('the damaged journal is kept as table %s', aside)

    def name_history(self, database: Database, history: str, *, restored: bool = False) -> None:
        """Give the journal the id of another history, also in the list of cells."""
        super().name_history(database, history, restored=restored)
        database.execute(
            'UPDATE plant.cells SET history = ? WHERE number = ?', (history, self._cell.number)
        )
        database.execute(
            'UPDATE plant.stretches SET history = ? WHERE tables = ?', (history, self._tables)
        )

    def take(self, database: Any, page: Sequence[rows.Row]) -> None:
        """Write rows of events of another journal unchanged."""
        new = []
        for row in page:
            text = row.text.decode()
            event = json.loads(text)
            ends = 1 if row.ends is None else row.ends
            new.append(_New(row.seq, text, ends, event['event'], event.get('job'), event['time']))
        database.ask(_TAKE, _columns(new))

    def close(self) -> None:
        """Release the lock, and close the connections."""
        with suppress(psycopg.Error):
            self._writer.within_s = RUNNING_S
            self._writer.ask('SELECT pg_advisory_unlock_all()')
        self._writer.close()
        self._reading.close()
        self._mark.close()

    # --- connections --------------------------------------------------------------------------

    def _session(self, until: float) -> Session:
        """Return the session that writes; a new one if the last one is gone."""
        if self._writer.is_broken:
            self._writer.close()
            self._writer = self._once_more(until)
            self._reading.close()  # it does not know yet
        if self._reading.is_broken:
            with suppress(psycopg.Error, JournalUnusable):  # nobody needs it now
                self._reading = self._reader()
        self._writer.until = until
        return self._writer

    def _once_more(self, until: float) -> Session:
        connection = self._connected(max(until - time.monotonic(), 0.0), WRITING)
        session = Session(connection, self.patience_s)
        session.until = until
        try:
            self._enter_tables(session)
            while not self._is_locked(session):
                self._refuse_another(session)
                if time.monotonic() + AGAIN_S >= until:
                    raise AnotherWriter('another session has the lock of the cell')
                time.sleep(AGAIN_S)
        except BaseException:
            session.close()
            raise
        if self._is_running:
            self._abide(session)
        return session

    def _is_locked(self, session: Session) -> bool:
        """Take the lock; a session of this process that still has it is ended."""
        session.ask(
            'SELECT pg_terminate_backend(pid) FROM pg_locks WHERE pid = $1 '
            "AND locktype = 'advisory' AND classid = $2 AND objid = $3",
            (self._writer.backend, LOCK, self._cell.number),
        )
        answer = session.ask('SELECT pg_try_advisory_lock($1, $2)', (LOCK, self._cell.number))
        return bool(answer.fetchone()[0])

    def _refuse_another(self, session: Session) -> None:
        query = 'SELECT 1 FROM plant.cells WHERE number = $1 AND epoch = $2 FOR SHARE'
        if session.ask(query, (self._cell.number, self._cell.epoch)).fetchone() is None:
            raise AnotherWriter(_TAKEN_OVER)

    def _reader(self) -> Session:
        within_s = RUNNING_S if self._is_running else STARTING_S
        session = Session(self._connected(within_s), within_s)
        self._enter_tables(session)
        return session

    def _enter_tables(self, session: Session) -> None:
        session.ask(f'SET search_path = {self._tables}')

    def _connected(self, within_s: float, settings: Sequence[str] = ()) -> Connection:
        return connected(self._place, 'node', (*SETTINGS, *settings), connect_s=within_s)

    # --- contexts -----------------------------------------------------------------------------

    @contextmanager
    def writing(self) -> Iterator[Session]:
        with self._failing():
            session = self._session(time.monotonic() + self.patience_s)
            with self._transaction(session):
                yield session

    @contextmanager
    def _transaction(self, session: Session) -> Iterator[None]:
        session.ask('BEGIN')
        try:
            self._refuse_another(session)
            yield
            if session.ask('COMMIT').words != 'COMMIT':
                raise psycopg.DatabaseError('a part of it failed, so nothing is written')
        except BaseException:
            if not session.is_broken:
                session.ask('ROLLBACK')
            raise

    @contextmanager
    def looking(self) -> Iterator[Session]:
        with self._usable():
            if self._reading.is_broken:
                raise JournalUnusable(
                    f'the journal {self._place} cannot be reached; it is tried again with the '
                    'next event'
                )
            yield self._reading

    @contextmanager
    def _failing(self) -> Iterator[None]:
        try:
            yield
        except (psycopg.Error, JournalUnusable) as error:
            what = ' '.join(str(error).split())
            raise JournalFailed(f'the journal {self._place} cannot be written: {what}') from error

    @contextmanager
    def _usable(self) -> Iterator[None]:
        try:
            yield
        except psycopg.Error as error:
            what = ' '.join(str(error).split())
            raise JournalUnusable(f'the journal {self._place} cannot be used: {what}') from error
        except (KeyError, TypeError, ValueError) as error:
            raise JournalUnusable(
                f'the journal {self._place} holds a record that cannot be read: {error!r}; '
                'restore a backup of the database'
            ) from error


_TAKEN_OVER = 'another orchestrator has taken over the cell'

_CHECKS = 2
"""Place of the checks among the columns."""

_TAKE = """\
INSERT INTO events (seq, record, checksum, ends, event, job, time) SELECT new.* FROM unnest(
    $1::bigint[], $2::text[], $3::bigint[], $4::smallint[], $5::text[], $6::text[], $7::float8[]
) AS new"""
"""Writes events."""

_APPEND = f"""\
WITH fence AS (
    SELECT 1 FROM plant.cells WHERE number = $8 AND epoch = $9 FOR SHARE
), written AS (
    {_TAKE}
    WHERE EXISTS (SELECT FROM fence) AND $10 = greatest(
        (SELECT max(seq) FROM events), (SELECT kept_from - 1 FROM history)
    )
    RETURNING seq, event, job
), queued AS (
    INSERT INTO queued SELECT seq, job FROM written WHERE event = 'job.queued'
)
SELECT count(*) FROM written"""
"""The same if this is still the writer, and if they follow the last event."""


class _New(NamedTuple):
    """The row of an event to be written."""

    seq: int
    text: str
    ends: int
    event: str
    job: str | None
    time: float


def _new_rows(events: Sequence[Event]) -> Iterator[_New]:
    for event in events:
        ends = int(event is events[-1])
        job = getattr(event, 'job', None)
        yield _New(event.seq, to_text(event), ends, event.event, job, event.time)


def _columns(new: Iterable[_New]) -> Sequence[str]:
    seqs, texts, ends, events, jobs, times = zip(*new, strict=True)
    checks = map(check_of_event, seqs, texts, ends)
    return [array_of(column) for column in (seqs, texts, checks, ends, events, jobs, times)]


def _floor_of(session: Session) -> int:
    return max(rows.last_seq(session), kept_from(session) - 1)


def mark_place(place: Place, folder: Path | None = None) -> Path:
    """Return the name of a journal in the folder of this machine's marks.

    :param folder: None: that of the service, or of the user
    """
    if folder is None:
        given = os.environ.get('STATE_DIRECTORY') or os.environ.get('XDG_STATE_HOME')
        folder = Path(given or Path.home() / '.local' / 'state') / 'bt_orchestrator'
    server = conninfo_to_dict(place.address)
    parts = (server.get('host'), server.get('port'), server.get('dbname'), place.cell)
    return folder / quote('.'.join(str(part) for part in parts if part), safe='')
