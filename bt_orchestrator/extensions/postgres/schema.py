"""The tables of a plant's database, their versions and their upgrades (docs/plant.md).

Each cell has tables of its own, in a schema of its own (`cell_1`) with its own version: its writer
alone upgrades them, and waits for no other cell. They are those of a journal file. `plant.cells`
lists the cells, `plant.stretches` their tables; the views of `plant` put these together.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import NamedTuple

from psycopg import errors, sql

from bt_orchestrator.base.errors import JournalUnusable
from bt_orchestrator.extensions.postgres.connecting import Connection, Place
from bt_orchestrator.extensions.postgres.views import view_statements

FEED, JOURNAL = 'feed', 'journal'
"""The tables of a cell are a copy of a journal that is elsewhere, or the journal itself."""

LOCK = 0x6274
"""First key of the advisory locks; the second one is the number of the cell, 0: of the plant."""

LOCK_TIMEOUT_S = 2
"""An upgrade that waits longer for a report gives up: everything else would wait behind it."""

_PLANT = (
    'CREATE SCHEMA IF NOT EXISTS plant',
    """CREATE TABLE IF NOT EXISTS plant.cells (
           number integer GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
           cell text COLLATE "C" NOT NULL UNIQUE,
           -- `feed`: a copy. No node may ever go on from it: the newest events may be missing.
           kept_by text NOT NULL CHECK (kept_by IN ('feed', 'journal')),
           -- Of its newest stretch.
           history text NOT NULL DEFAULT '',
           -- Counts the writers. Who finds a higher one is no writer any more.
           epoch bigint NOT NULL DEFAULT 0,
           holder text NOT NULL DEFAULT '',
           since timestamptz,
           -- The last moment at which the writer knew that nothing was missing here.
           complete_at timestamptz,
           -- Address of the operator page of the cell.
           page text NOT NULL DEFAULT ''
       )""",
    # The tables of a cell, once for each history of its journal. A journal that was restored goes
    # on from events of another one: these stay in the stretch in which they were written first.
    """CREATE TABLE IF NOT EXISTS plant.stretches (
           number integer GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
           cell integer NOT NULL REFERENCES plant.cells,
           history text NOT NULL,
           parent integer REFERENCES plant.stretches,
           -- The first event that is of this history and not of its parent.
           first_seq bigint NOT NULL DEFAULT 1,
           -- Of its tables, and the schema in which they are.
           version integer NOT NULL,
           tables text NOT NULL UNIQUE,
           UNIQUE (cell, history)
       )""",
    # A record as jsonb. PostgreSQL refuses NUL and lone surrogates in it, which records may have.
    r"""CREATE OR REPLACE FUNCTION plant.fact(record text) RETURNS jsonb
           LANGUAGE sql IMMUTABLE PARALLEL SAFE STRICT
           AS $$ SELECT regexp_replace(
               record, '\\u(0000|d[89a-f][0-9a-f]{2})', '\\ufffd', 'gi')::jsonb $$""",
    # `check_of_event`, which the server can work out itself.
    """CREATE OR REPLACE FUNCTION plant.check_of_event(seq bigint, record text, ends integer)
           RETURNS bigint LANGUAGE sql IMMUTABLE PARALLEL SAFE STRICT
           AS $$ SELECT ('x' || left(md5(seq || ' ' || ends || ' ' || record), 8))
               ::bit(32)::bigint $$""",
)

_STEPS: Sequence[Sequence[str]] = (
    # 1: the tables of a journal file (store/sqlite/schema.py), with columns for queries.
    (
        # `record` is the text as it was written, byte for byte; the columns are taken from it.
        """CREATE TABLE {stretch}.events (
               seq bigint PRIMARY KEY,
               record text NOT NULL,
               checksum bigint,
               ends smallint,
               event text COLLATE "C" NOT NULL,
               job text COLLATE "C",
               time double precision NOT NULL
           )""",
        'CREATE INDEX ON {stretch}.events (job, seq) WHERE job IS NOT NULL',
        'CREATE INDEX ON {stretch}.events USING brin (time)',
        """CREATE INDEX ON {stretch}.events (event, time)
               WHERE event IN ('cell.state_changed', 'cell.stop_reason_changed')""",
        # Events that never came: removed before they were copied, or damaged in the journal.
        """CREATE TABLE {stretch}.gaps (
               first_seq bigint PRIMARY KEY,
               last_seq bigint NOT NULL,
               why text NOT NULL CHECK (why IN ('removed', 'damaged')),
               noticed timestamptz NOT NULL DEFAULT now()
           )""",
        """CREATE TABLE {stretch}.history (
               one smallint PRIMARY KEY CHECK (one = 1),
               id text NOT NULL,
               restored smallint NOT NULL DEFAULT 0 CHECK (restored IN (0, 1)),
               checksum bigint,
               checked_from bigint NOT NULL DEFAULT 1,
               kept_from bigint NOT NULL DEFAULT 1
           )""",
        'CREATE TABLE {stretch}.queued (seq bigint PRIMARY KEY, job text NOT NULL)',
        'CREATE TABLE {stretch}.unclosed (one smallint PRIMARY KEY CHECK (one = 1))',
        """CREATE TABLE {stretch}.jobs (
               job text COLLATE "C" NOT NULL,
               queued double precision NOT NULL,
               summary text NOT NULL,
               checksum bigint,
               PRIMARY KEY (job, queued)
           )""",
        """CREATE TABLE {stretch}.snapshots (
               seq bigint PRIMARY KEY,
               stamp text NOT NULL,
               checksum text NOT NULL,
               state text NOT NULL
           )""",
        """CREATE TABLE {stretch}.beginning (
               one smallint PRIMARY KEY CHECK (one = 1),
               seq bigint NOT NULL,
               stamp text NOT NULL,
               checksum text NOT NULL,
               state text NOT NULL
           )""",
        """CREATE TABLE {stretch}.book_slots (
               begin_us bigint PRIMARY KEY,
               until_us bigint NOT NULL,
               made_of bigint NOT NULL,
               version integer NOT NULL,
               slot text NOT NULL,
               checksum bigint NOT NULL
           )""",
        """CREATE TABLE {stretch}.book_states (
               seq bigint PRIMARY KEY,
               now_us bigint NOT NULL,
               made_of bigint NOT NULL,
               stays smallint NOT NULL CHECK (stays IN (0, 1)),
               version integer NOT NULL,
               state text NOT NULL,
               checksum bigint NOT NULL
           )""",
        """CREATE TABLE {stretch}.book_scripts (
               digest text COLLATE "C" PRIMARY KEY,
               script text NOT NULL,
               checksum bigint NOT NULL
           )""",
        """CREATE TABLE {stretch}.used_ids (
               digest text COLLATE "C" NOT NULL,
               copy integer NOT NULL,
               ids text NOT NULL,
               PRIMARY KEY (digest, copy)
           )""",
    ),
    # 2: the reasons of stops (schema 8 of a journal file).
    (
        """CREATE TABLE {stretch}.book_reasons (
               made_of bigint PRIMARY KEY,
               reason text NOT NULL,
               checksum bigint NOT NULL
           )""",
    ),
)

VERSION = len(_STEPS)
"""Of the tables of a stretch."""

READER = 'plant_reader'
"""Gets the right to read everything, if there is such a role."""


class CellRefused(JournalUnusable):
    """The database cannot have this cell: a person has to change something."""


class CellTaken(JournalUnusable):
    """Another program writes the cell."""


class Cell(NamedTuple):
    """A cell of the plant."""

    number: int
    name: str
    kept_by: str
    history: str
    """Of its newest stretch; empty: it has none yet."""
    epoch: int
    page: str


class Stretch(NamedTuple):
    """The tables of a cell for one history of its journal."""

    number: int
    history: str
    parent: int | None
    """The stretch with the events before `first_seq`."""
    first_seq: int
    version: int
    tables: str
    """Name of the schema in which they are."""

    def sql(self, text: str) -> sql.Composed:
        """Return a statement with `{stretch}` replaced by the schema."""
        return sql.SQL(text).format(stretch=sql.Identifier(self.tables))


class Gap(NamedTuple):
    """Events that will never come."""

    first: int
    last: int
    why: str
    """removed, or damaged."""

    def __str__(self) -> str:
        """Return the sentence for a person."""
        many = self.first < self.last
        what = f'events {self.first} to {self.last}' if many else f'event {self.first}'
        were = 'were' if many else 'was'
        if self.why == 'removed':
            return f'{what} {were} removed from the journal before they could be copied'
        return f'{what} {were} damaged in the journal, and could not be copied'


_CELL = 'SELECT number, cell, kept_by, history, epoch, page FROM plant.cells '
_STRETCH = 'SELECT number, history, parent, first_seq, version, tables FROM plant.stretches '


def cells(connection: Connection) -> list[Cell]:
    """Return the cells of a plant, in the order of their names.

    :raises JournalUnusable: it is no plant's database
    """
    try:
        rows = connection.execute(f'{_CELL} ORDER BY cell'.encode()).fetchall()
    except (errors.UndefinedTable, errors.InvalidSchemaName) as error:
        raise JournalUnusable(
            'the database has no cells of a plant; `bt-orchestrator feed` makes the first one'
        ) from error
    return [Cell(*row) for row in rows]


def cell_named(connection: Connection, place: Place) -> Cell:
    """Return a cell of a plant.

    :raises JournalUnusable: it is not in the database
    """
    known = cells(connection)
    for cell in known:
        if cell.name == place.cell:
            return cell
    names = ', '.join(cell.name for cell in known) or 'none'
    raise JournalUnusable(
        f"expected a cell of the plant's database {place.of('')}, found {place.cell!r}; it has: "
        f'{names}'
    )


def stretches(connection: Connection, cell: Cell) -> list[Stretch]:
    """Return the stretches of a cell, oldest first.

    :raises JournalUnusable: one has tables of a newer program
    """
    query = f'{_STRETCH} WHERE cell = %s ORDER BY number'.encode()
    cell_stretches = [Stretch(*row) for row in connection.execute(query, (cell.number,))]
    newest = max((stretch.version for stretch in cell_stretches), default=0)
    if newest > VERSION:
        raise CellRefused(
            f'the tables of the cell {cell.name} have version {newest}, this program knows '
            f'{VERSION}; use the newer program'
        )
    return cell_stretches


def enter(connection: Connection, name: str, kept_by: str, holder: str) -> Cell:
    """Take the lock of a cell, make its tables current, and return it.

    The first time this makes the cell, and the plant. The lock is held until the connection ends.

    :param kept_by: `FEED` or `JOURNAL`
    :param holder: names the writer for others
    :raises JournalUnusable: another writer has it, it is kept in another way, or it is newer
    """
    _refuse_encoding(connection)
    with _patient(connection), connection.transaction():
        _lock_plant(connection)
        if not _has_plant(connection):
            for statement in _PLANT:
                connection.execute(statement.encode())
        _let_read(connection, 'plant')
        connection.execute(
            'INSERT INTO plant.cells (cell, kept_by) VALUES (%s, %s) ON CONFLICT DO NOTHING',
            (name, kept_by),
        )
    cell = _row(connection, name)
    refuse_kept_otherwise(cell, kept_by)
    known = stretches(connection, cell)
    if not _wait_for_lock(connection, cell.number):
        raise CellTaken(
            f'another program writes the cell {name}: {_holder_of(connection, name)}; the cell is '
            'in use by another orchestrator, or by a feed: end that one, or use another cell name'
        )
    with _patient(connection), connection.transaction():
        for stretch in known:
            _bring_up_to_date(connection, stretch)
        connection.execute(
            'UPDATE plant.cells SET epoch = epoch + 1, holder = %s, since = now() '
            'WHERE number = %s',
            (holder, cell.number),
        )
    return _row(connection, name)


def begin_stretch(
    connection: Connection,
    cell: Cell,
    history: str,
    parent: Stretch | None = None,
    first_seq: int = 1,
) -> Stretch:
    """Make the tables of another history of a cell whose lock this connection has.

    :param parent: the stretch with the events before `first_seq`; None: there are none
    """
    number = 1 + len(stretches(connection, cell))
    tables = f'cell_{cell.number}' + (f'_{number}' if number > 1 else '')
    values = (cell.number, history, parent and parent.number, first_seq, tables)
    with _patient(connection), connection.transaction():
        connection.execute(
            'INSERT INTO plant.stretches (cell, history, parent, first_seq, version, tables) '
            'VALUES (%s, %s, %s, %s, 0, %s)',
            values,
        )
        connection.execute(
            sql.SQL('CREATE SCHEMA IF NOT EXISTS {}').format(sql.Identifier(tables))
        )
        _bring_up_to_date(connection, stretches(connection, cell)[-1])
        connection.execute(
            'UPDATE plant.cells SET history = %s WHERE number = %s', (history, cell.number)
        )
    return stretches(connection, cell)[-1]


def refuse_kept_otherwise(cell: Cell, kept_by: str) -> None:
    """Check that a cell is a journal, or that it is a copy.

    :raises CellRefused: it is the other one
    """
    if cell.kept_by != kept_by:
        raise CellRefused(_KEPT_OTHERWISE[cell.kept_by].format(cell.name))


_KEPT_OTHERWISE = {
    FEED: (
        'the cell {} is a copy that a feed writes: the newest events may be missing, so no node '
        'may go on from it; use another cell name'
    ),
    JOURNAL: 'the cell {} is the journal of a node, and needs no feed; use another cell name',
}


def take_lock(connection: Connection, number: int) -> bool:
    """Take the advisory lock of a cell for as long as the connection lives; False: it is taken."""
    row = connection.execute('SELECT pg_try_advisory_lock(%s, %s)', (LOCK, number)).fetchone()
    return bool(row and row[0])


def _wait_for_lock(connection: Connection, number: int) -> bool:
    """Take the lock of a cell, which a server frees late when a writer was killed."""
    connection.execute(f'SET lock_timeout = {LOCK_TIMEOUT_S * 1000:.0f}'.encode())
    try:
        connection.execute('SELECT pg_advisory_lock(%s, %s)', (LOCK, number))
    except errors.LockNotAvailable:
        return False
    finally:
        connection.execute(b'RESET lock_timeout')
    return True


def check_of_event(seq: int, record: str, ends: int) -> int:
    """Return the check of the row of an event, which `plant.check_of_event` works out as well.

    :param ends: 1: it is the last one of its commit; 0: it is not
    """
    text = f'{seq} {ends} {record}'.encode()
    return int(hashlib.md5(text, usedforsecurity=False).hexdigest()[:8], 16)


def check_of_row(seq: int, record: bytes, ends: int) -> int:
    """Return the same of a record as it was read."""
    return check_of_event(seq, record.decode(), ends)


def _lock_plant(connection: Connection) -> None:
    """Let one program at a time change what all cells have in common."""
    connection.execute('SELECT pg_advisory_xact_lock(%s, 0)', (LOCK,))


def _holder_of(connection: Connection, name: str) -> str:
    row = connection.execute(
        "SELECT holder || ' since ' || to_char(since, 'YYYY-MM-DD HH24:MI TZ') "
        'FROM plant.cells WHERE cell = %s',
        (name,),
    ).fetchone()
    return str(row[0]) if row and row[0] else 'not known'


def _row(connection: Connection, name: str) -> Cell:
    row = connection.execute(f'{_CELL} WHERE cell = %s'.encode(), (name,)).fetchone()
    assert row is not None
    return Cell(*row)


def _has_plant(connection: Connection) -> bool:
    row = connection.execute("SELECT to_regclass('plant.stretches')").fetchone()
    return bool(row and row[0])


def _bring_up_to_date(connection: Connection, stretch: Stretch) -> None:
    """Make the tables that a stretch lacks, and the views over all of them anew."""
    if stretch.version == VERSION:
        return
    for step in _STEPS[stretch.version :]:
        for statement in step:
            connection.execute(stretch.sql(statement))
    connection.execute(
        'UPDATE plant.stretches SET version = %s WHERE number = %s', (VERSION, stretch.number)
    )
    _let_read(connection, stretch.tables)
    _lock_plant(connection)  # views made of an older list would lack a stretch
    _make_views(connection)


def _make_views(connection: Connection) -> None:
    query = (
        'SELECT s.number, c.cell, s.tables, s.version FROM plant.stretches s '
        'JOIN plant.cells c ON c.number = s.cell ORDER BY s.number'
    )
    for statement in view_statements(connection.execute(query).fetchall()):
        connection.execute(statement)


def _let_read(connection: Connection, schema: str) -> None:
    row = connection.execute(
        "SELECT has_schema_privilege(rolname, %s, 'USAGE') FROM pg_roles WHERE rolname = %s",
        (schema, READER),
    ).fetchone()
    if row is None or row[0]:
        return
    for statement in (
        'GRANT USAGE ON SCHEMA {schema} TO {reader}',
        'GRANT SELECT ON ALL TABLES IN SCHEMA {schema} TO {reader}',
        'ALTER DEFAULT PRIVILEGES IN SCHEMA {schema} GRANT SELECT ON TABLES TO {reader}',
    ):
        connection.execute(
            sql.SQL(statement).format(schema=sql.Identifier(schema), reader=sql.Identifier(READER))
        )


def _refuse_encoding(connection: Connection) -> None:
    encoding = connection.info.parameter_status('server_encoding')
    if encoding != 'UTF8':
        raise CellRefused(
            f'expected a database with the encoding UTF8, found {encoding}; make one with: '
            "CREATE DATABASE plant ENCODING 'UTF8' TEMPLATE template0"
        )


@contextmanager
def _patient(connection: Connection) -> Iterator[None]:
    """Wait for locks of others for a short time only.

    :raises JournalUnusable: somebody else has one for longer
    """
    connection.execute(f'SET lock_timeout = {LOCK_TIMEOUT_S * 1000:.0f}'.encode())
    try:
        yield
    except errors.LockNotAvailable as error:
        raise JournalUnusable(
            'tables cannot be made or upgraded while a long report reads them; end it, or try '
            'again later'
        ) from error
    finally:
        if not connection.closed and not connection.broken:
            connection.execute(b'RESET lock_timeout')
