"""The tables of a journal, their version, and how an older file becomes one of today.

Schema 1 had the events alone. Schema 2 adds what is derived from them: states to start from, the
summaries of jobs that ended, and where jobs begin. Schema 3 adds a name that no other journal has.
A step forward adds and never rewrites events; each runs in one transaction, so a file is of one
schema or of the other, whatever happens.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from bt_orchestrator.store.database import JournalUnusable, pragma, transaction

SCHEMA = 3
"""Version of the tables, kept in SQLite's user_version."""

APPLICATION_ID = 0x62746F72
"""Says that a file is a journal of ours (`btor`), and not some other SQLite file."""

_RANDOM = 'lower(hex(randomblob(16)))'

_STEPS: Sequence[Sequence[str]] = (
    # 1
    ('CREATE TABLE events (seq INTEGER PRIMARY KEY, record TEXT NOT NULL) STRICT',),
    # 2
    (
        # What the state was after an event; a cache, of which the newest good one is used.
        """CREATE TABLE snapshots (
               seq INTEGER PRIMARY KEY,
               stamp TEXT NOT NULL,
               checksum TEXT NOT NULL,
               state TEXT NOT NULL
           ) STRICT""",
        # The same, once retention has removed the first events: then replay begins here.
        """CREATE TABLE beginning (
               one INTEGER PRIMARY KEY CHECK (one = 1),
               seq INTEGER NOT NULL,
               stamp TEXT NOT NULL,
               checksum TEXT NOT NULL,
               state TEXT NOT NULL
           ) STRICT""",
        # Jobs that ended, for the time when their events are gone.
        """CREATE TABLE jobs (
               job TEXT NOT NULL,
               queued REAL NOT NULL,
               summary TEXT NOT NULL,
               PRIMARY KEY (job, queued)
           ) STRICT""",
        # The events with which jobs begin, so that nobody has to look through all of them.
        """CREATE INDEX jobs_queued ON events (seq, json_extract(record, '$.job'))
               WHERE json_extract(record, '$.event') = 'job.queued'""",
    ),
    # 3
    (
        # Which history the events are of, and whether it goes on from a restored copy.
        """CREATE TABLE history (
               one INTEGER PRIMARY KEY CHECK (one = 1),
               id TEXT NOT NULL,
               restored INTEGER NOT NULL DEFAULT 0 CHECK (restored IN (0, 1))
           ) STRICT""",
        f'INSERT INTO history (one, id) VALUES (1, {_RANDOM})',
    ),
)


def schema_of(database: sqlite3.Connection, path: Path) -> int:
    """Return the schema of a journal; 0: the file is new.

    :raises JournalUnusable: it is not ours, or newer than this program
    """
    version = pragma(database, 'user_version')
    tables = database.execute('SELECT count(*) FROM sqlite_schema').fetchone()[0]
    if pragma(database, 'application_id') != APPLICATION_ID and (version or tables):
        raise JournalUnusable(f'{path} is an SQLite file, but no journal of an orchestrator')
    if version > SCHEMA:
        raise JournalUnusable(
            f'the journal {path} has schema {version}, this program knows {SCHEMA}; use the newer '
            'program, or name another file'
        )
    return version


def bring_up_to_date(database: sqlite3.Connection, version: int) -> None:
    """Make the tables of a new file, or those that an older one lacks."""
    with transaction(database):
        for step in _STEPS[version:]:
            for statement in step:
                database.execute(statement)
        database.execute(f'PRAGMA application_id = {APPLICATION_ID}')
        database.execute(f'PRAGMA user_version = {SCHEMA}')


class History(NamedTuple):
    """Which history a journal holds."""

    id: str
    is_restored: bool
    """It goes on from a copy that was brought back."""


def history_of(database: sqlite3.Connection) -> History:
    """Return the history that a journal of today holds.

    :raises ValueError: it has none
    """
    row = database.execute('SELECT id, restored FROM history').fetchone()
    if row is None:
        raise ValueError('the table history is empty')
    return History(str(row[0]), bool(row[1]))


def begin_restored(database: sqlite3.Connection) -> None:
    """Let a journal of today, which is a copy, begin a history of its own."""
    database.execute(f'UPDATE history SET id = {_RANDOM}, restored = 1')
