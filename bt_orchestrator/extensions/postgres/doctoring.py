"""Whether a database can keep the journal of a cell: what `doctor` looks at."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import closing
from typing import Any

import psycopg

from bt_orchestrator.base.diagnosis.check import Check, fail, ok, warn
from bt_orchestrator.base.errors import JournalUnusable
from bt_orchestrator.extensions.postgres.connecting import Connection, Place, connected, place_of
from bt_orchestrator.extensions.postgres.schema import FEED, LOCK, cells

OLDEST = 14
"""First version of PostgreSQL that is supported."""

MOST_OFFSET_S = 1.0
"""Offset of two clocks above which times of events and of the database are hard to compare."""

DATABASE, WRITES, COPIES, CLOCK, CELL = (
    *('journal database', 'journal writes', 'journal replicas', 'database clock'),
    'journal cell',
)


def checks(address: str) -> Iterator[Check]:
    """Yield the checks of a database, each at once when it is done. Changes nothing."""
    try:
        place = place_of(address)
        connection = connected(place, 'doctor', ['SET statement_timeout = 5000'])
    except JournalUnusable as error:
        yield fail(DATABASE, str(error), 'check address, server, role and ~/.pgpass')
        return
    with closing(connection):
        try:
            yield _server(connection, place)
            yield _writes(connection)
            yield _replicas(connection)
            yield _clock(connection)
            yield _cell(connection, place)
        except psycopg.Error as error:
            yield fail(DATABASE, f'{place}: {error}', 'look into the log of the server')


def _server(connection: Connection, place: Place) -> Check:
    version, encoding = _one(
        connection, "SELECT current_setting('server_version'), current_setting('server_encoding')"
    )
    if connection.info.server_version < OLDEST * 10_000:
        return fail(
            DATABASE, f'{place}: PostgreSQL {version}', f'use PostgreSQL {OLDEST} or newer'
        )
    if encoding != 'UTF8':
        remedy = "CREATE DATABASE plant ENCODING 'UTF8' TEMPLATE template0"
        return fail(DATABASE, f'{place}: encoding {encoding}', f'make another one: {remedy}')
    (backend,) = _one(connection, 'SELECT pg_backend_pid()')
    if backend != connection.info.backend_pid:
        return fail(
            DATABASE, f'{place}: a pooler stands before the server', 'name the server itself'
        )
    return ok(DATABASE, f'{place}: PostgreSQL {version}')


def _writes(connection: Connection) -> Check:
    is_replica, may_create = _one(
        connection,
        "SELECT pg_is_in_recovery(), has_database_privilege(current_database(), 'CREATE')",
    )
    if is_replica:
        return fail(
            WRITES,
            'the server is a replica, which takes no writes',
            'name all servers, and add ?target_session_attrs=read-write',
        )
    if not may_create:
        return fail(
            WRITES,
            'the role may not make tables',
            'ALTER DATABASE … OWNER TO the role of the node',
        )
    return ok(WRITES, 'the role may make tables')


def _replicas(connection: Connection) -> Check:
    named, waited_for, others, hidden = _one(
        connection,
        "SELECT current_setting('synchronous_standby_names'), "
        "count(*) FILTER (WHERE sync_state IN ('sync', 'quorum')), "
        "count(*) FILTER (WHERE sync_state NOT IN ('sync', 'quorum')), "
        'count(*) FILTER (WHERE sync_state IS NULL) FROM pg_stat_replication '
        "WHERE state IS DISTINCT FROM 'backup'",
    )
    if not named and others + hidden:
        return fail(
            COPIES,
            f'{others + hidden} replicas, and no commit waits for one: a promotion loses events',
            'set synchronous_standby_names to a quorum of replicas (docs/postgres.md)',
        )
    if not named:
        return warn(
            COPIES,
            'no commit waits for a replica: events are lost with the disk of the server',
            'set synchronous_standby_names to a quorum of replicas (docs/postgres.md)',
        )
    if hidden:
        return warn(
            COPIES,
            f'commits wait for {named}; this role may not see which of {hidden} replicas that are',
            'GRANT pg_read_all_stats TO the role of the node, and check again',
        )
    if not waited_for:
        return fail(
            COPIES,
            f'commits wait for {named}, and no such replica is connected: every write hangs',
            'start the replica, or correct synchronous_standby_names',
        )
    if others:
        return warn(
            COPIES,
            f'commits wait for {waited_for}, and not for {others} others, which may lack the last '
            'events',
            'promote only a replica that commits wait for',
        )
    return ok(COPIES, f'commits wait for {waited_for} of: {named}')


def _clock(connection: Connection) -> Check:
    before = time.time()
    (there,) = _one(connection, 'SELECT extract(epoch FROM clock_timestamp())::float8')
    offset = there - (before + time.time()) / 2
    if abs(offset) > MOST_OFFSET_S:
        return warn(
            CLOCK,
            f'the clock of the database is {offset:+.1f} s off this one',
            'synchronize both with NTP',
        )
    return ok(CLOCK, f'{offset:+.3f} s off this one')


def _cell(connection: Connection, place: Place) -> Check:
    if not place.cell:
        return fail(CELL, f'{place} names no cell', 'add /CELL to the address')
    try:
        kept_cell = next((cell for cell in cells(connection) if cell.name == place.cell), None)
    except JournalUnusable:
        kept_cell = None
    if kept_cell is None:
        return ok(CELL, f'{place.cell} has no journal there yet; the first start makes it')
    if kept_cell.kept_by == FEED:
        return fail(
            CELL,
            f'{place.cell} is a copy that a feed writes, and may lack the newest events',
            'use another cell name for the journal',
        )
    leader, is_led = _one(
        connection,
        "SELECT holder, EXISTS (SELECT FROM pg_locks WHERE locktype = 'advisory' "
        f'AND classid = {LOCK} AND objid = cells.number AND database = '
        '(SELECT oid FROM pg_database WHERE datname = current_database())) '
        f'FROM plant.cells WHERE number = {kept_cell.number}',
    )
    led = f'led by {leader}' if is_led else f'led by no node now, last by {leader}'
    return ok(
        CELL,
        f'{place.cell} has its journal there, history {kept_cell.history}; {led}, '
        f'epoch {kept_cell.epoch}',
    )


def _one(connection: Connection, query: str) -> tuple[Any, ...]:
    row = connection.execute(query.encode()).fetchone()
    assert row is not None
    return tuple(row)
