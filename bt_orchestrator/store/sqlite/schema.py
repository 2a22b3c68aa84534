"""The tables of a journal, their version, and the upgrade of older files.

Schema 1 had the events alone. Schema 2 adds derived data: states to start from, summaries of jobs
that ended, and where jobs begin. Schema 3 adds a unique id of the journal. Schema 4 adds a check
to every row; older rows stay without one. Schema 5 adds whether a node has closed the file.
Schema 6 adds books: the account in slots of time, which outlives the events that it was made of.
Schema 7 adds parts of the ids that were ever used, which states name.
Schema 8 adds to the books the reasons that operators gave for stops of the line.
An upgrade adds and never rewrites events; each step runs in one transaction, so a file always has
one schema or the other.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Sequence
from pathlib import Path

from bt_orchestrator.base.errors import JournalUnusable
from bt_orchestrator.store.shared.database import seal
from bt_orchestrator.store.sqlite.database import pragma, transaction

SCHEMA = 8
"""Version of the tables, kept in SQLite's user_version."""

APPLICATION_ID = 0x62746F72
"""Says that a file is a journal of ours (`btor`), and not some other SQLite file."""

_RANDOM = 'lower(hex(randomblob(16)))'

_STEPS: Sequence[Sequence[str]] = (
    # 1
    ('CREATE TABLE events (seq INTEGER PRIMARY KEY, record TEXT NOT NULL) STRICT',),
    # 2
    (
        # States after events; a cache, the newest sound one is used.
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
        # Jobs that ended, kept after their events are removed.
        """CREATE TABLE jobs (
               job TEXT NOT NULL,
               queued REAL NOT NULL,
               summary TEXT NOT NULL,
               PRIMARY KEY (job, queued)
           ) STRICT""",
        # The events with which jobs begin, to avoid a scan of all events.
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
    # 4
    (
        # See `shared.database`. NULL: written by an older version.
        'ALTER TABLE events ADD COLUMN checksum INTEGER',
        # 1: the last event of a commit. Only after such an event is a settle complete.
        'ALTER TABLE events ADD COLUMN ends INTEGER',
        'ALTER TABLE jobs ADD COLUMN checksum INTEGER',
        'ALTER TABLE history ADD COLUMN checksum INTEGER',
        # From this event on every one has a check.
        'ALTER TABLE history ADD COLUMN checked_from INTEGER NOT NULL DEFAULT 1',
        'UPDATE history SET checked_from = (SELECT coalesce(max(seq), 0) + 1 FROM events)',
        # Retention has removed the events before this one; any other missing event is a loss.
        'ALTER TABLE history ADD COLUMN kept_from INTEGER NOT NULL DEFAULT 1',
        """UPDATE history SET kept_from = coalesce(
               (SELECT min(seq) FROM events), (SELECT max(seq) + 1 FROM beginning), 1)""",
        # The events with which jobs begin; not an index on the records, because then no row with
        # a damaged record could be removed.
        'CREATE TABLE queued (seq INTEGER PRIMARY KEY, job TEXT NOT NULL) STRICT',
        """INSERT INTO queued SELECT seq, json_extract(record, '$.job') FROM events
               WHERE json_extract(record, '$.event') = 'job.queued'""",
        'DROP INDEX jobs_queued',
    ),
    # 5
    (
        # Has a row from the first write of a node until it closes the journal.
        'CREATE TABLE unclosed (one INTEGER PRIMARY KEY CHECK (one = 1)) STRICT',
    ),
    # 6
    (
        # The account of a stretch of time; `made_of` is the last event that has a say in it.
        """CREATE TABLE book_slots (
               begin_us INTEGER PRIMARY KEY,
               until_us INTEGER NOT NULL,
               made_of INTEGER NOT NULL,
               version INTEGER NOT NULL,
               slot TEXT NOT NULL,
               checksum INTEGER NOT NULL
           ) STRICT""",
        # From where books and reports go on; of those that do not stay there is one, the newest.
        """CREATE TABLE book_states (
               seq INTEGER PRIMARY KEY,
               now_us INTEGER NOT NULL,
               made_of INTEGER NOT NULL,
               stays INTEGER NOT NULL CHECK (stays IN (0, 1)),
               version INTEGER NOT NULL,
               state TEXT NOT NULL,
               checksum INTEGER NOT NULL
           ) STRICT""",
        # What the pace of the account needs: scripts, each once.
        """CREATE TABLE book_scripts (
               digest TEXT PRIMARY KEY,
               script TEXT NOT NULL,
               checksum INTEGER NOT NULL
           ) STRICT""",
    ),
    # 7
    (
        # Ids of orders and serials, some thousand in a row; the digest is that of the text.
        """CREATE TABLE used_ids (
               digest TEXT NOT NULL,
               copy INTEGER NOT NULL,
               ids TEXT NOT NULL,
               PRIMARY KEY (digest, copy)
           ) STRICT""",
    ),
    # 8
    (
        # The decisions that say the reason of a stop, each as its event was written.
        """CREATE TABLE book_reasons (
               made_of INTEGER PRIMARY KEY,
               reason TEXT NOT NULL,
               checksum INTEGER NOT NULL
           ) STRICT""",
    ),
)


def schema_of(database: sqlite3.Connection, path: Path) -> int:
    """Return the schema of a journal; 0: the file is new.

    :raises JournalUnusable: it is not ours, or newer than this program
    """
    version = pragma(database, 'user_version')
    tables = database.execute('SELECT count(*) FROM sqlite_schema').fetchone()[0]
    if pragma(database, 'application_id') != APPLICATION_ID and (version or tables):
        raise JournalUnusable(
            f'{path} is an SQLite file, but no journal of an orchestrator; name another file'
        )
    if version > SCHEMA:
        raise JournalUnusable(
            f'the journal {path} has schema {version}, this program knows {SCHEMA}; use the newer '
            'program, or name another file'
        )
    return version


def bring_up_to_date(database: sqlite3.Connection, version: int) -> None:
    """Create the tables of a new file, or those that an older file lacks."""
    with transaction(database):
        for step in _STEPS[version:]:
            for statement in step:
                database.execute(statement)
        seal(database)
        database.execute(f'PRAGMA application_id = {APPLICATION_ID}')
        database.execute(f'PRAGMA user_version = {SCHEMA}')


CHECKED = 4
"""First schema with checks of rows."""

_OF_EVENTS = {
    'events': 'SELECT seq, record, NULL AS checksum, NULL AS ends FROM main.events',
    'history': 'SELECT coalesce(min(seq), 1) AS kept_from FROM main.events',
}


def look_like_today(database: sqlite3.Connection, version: int) -> None:
    """Let readers see the tables of today in an older file; nothing in it changes."""
    views = dict(_OF_EVENTS) if version < CHECKED else {}
    if 1 < version < CHECKED:
        views['jobs'] = 'SELECT *, NULL AS checksum FROM main.jobs'
    database.execute('PRAGMA temp_store = MEMORY')
    for name, query in views.items():
        database.execute(f'CREATE TEMP VIEW {name} AS {query}')
    for statement in (statement for step in _STEPS[version:] for statement in step):
        if statement.startswith('CREATE TABLE') and statement.split()[2] not in views:
            database.execute(statement.replace('TABLE', 'TEMP TABLE', 1))
    if version == 1:
        database.execute('ALTER TABLE jobs ADD COLUMN checksum INTEGER')


def begin_restored(database: sqlite3.Connection) -> None:
    """Begin a new history in a complete copy of the current schema."""
    with transaction(database):
        end_to_write(database)
        database.execute(f'UPDATE history SET id = {_RANDOM}, restored = 1')
        seal(database)


def begin_to_write(database: sqlite3.Connection) -> bool:
    """Mark the file as being written, if possible before an event is only in the log.

    :return: False: the mark is only in the log so far, because a reader keeps an older state
    """
    database.execute('INSERT OR IGNORE INTO unclosed VALUES (1)')
    _, frames, moved = database.execute('PRAGMA wal_checkpoint(PASSIVE)').fetchone()
    return bool(frames == moved)


def end_to_write(database: sqlite3.Connection) -> None:
    """Mark the file as closed: everything that the node wrote is in it."""
    database.execute('DELETE FROM unclosed')


def is_closed(database: sqlite3.Connection) -> bool:
    """Tell whether a journal of the current schema was closed by its node."""
    return database.execute('SELECT 1 FROM unclosed').fetchone() is None
