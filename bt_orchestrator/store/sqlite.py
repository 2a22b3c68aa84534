"""The durable journal: an SQLite file (semantics 9.1)."""

from __future__ import annotations

import errno
import fcntl
import json
import os
import sqlite3
from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from itertools import chain
from pathlib import Path
from typing import IO

from bt_orchestrator.errors import JournalFailed
from bt_orchestrator.model.codec import from_record, json_of, to_text
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.history import JobRecord, job_to_plain
from bt_orchestrator.ports import Snapshot
from bt_orchestrator.store import retention, snapshots
from bt_orchestrator.store.database import (
    JournalUnusable,
    transaction,
    unchanging,
    unusable_otherwise,
)
from bt_orchestrator.store.schema import SCHEMA, bring_up_to_date, schema_of

_AT_ONCE = 50
"""Most events that are written with one statement; a settle has a few."""

SYNCHRONOUS = ('FULL', 'NORMAL')


class SqliteStore:
    """A journal in a file. Implements `ports.Journal`.

    One transaction an append, in WAL mode, so that others may read while it is written. A lock on
    a file beside it keeps a second orchestrator out for as long as this one lives, and is gone
    when its process is, however that ends.

    A file is only read until the first write: whoever refuses what is in it has changed nothing.
    """

    def __init__(self, path: Path, *, synchronous: str = 'FULL') -> None:
        """Open or make a journal; an older one is brought up to date.

        :param synchronous: FULL (a power cut loses nothing) or NORMAL (it may lose the last
            events; a crash of the program loses nothing)
        :raises JournalUnusable: it is in use, not ours, newer, damaged, or cannot be written
        """
        if synchronous not in SYNCHRONOUS:
            known = ' or '.join(SYNCHRONOUS)
            raise JournalUnusable(f'a journal is written with {known}; found {synchronous!r}')
        self._path = path
        self._synchronous = synchronous
        self._lock = _locked(path)
        try:
            with unusable_otherwise(path):
                found = _found(path)
                self._database = found or _opened(path, synchronous)
                self._is_writable = found is None
        except BaseException:
            self._lock.close()
            raise

    # --- events -----------------------------------------------------------------------------

    def append(self, events: Sequence[Event]) -> None:
        """Make the events durable, all or none.

        :raises JournalFailed: they are not; nothing of them is in the journal
        """
        rows = [(event.seq, to_text(event)) for event in events]
        if len(rows) <= _AT_ONCE:  # one statement is a transaction of its own, and takes less time
            values = ', '.join(['(?, ?)'] * len(rows))
            with self._writable():
                self._database.execute(f'INSERT INTO events VALUES {values}', tuple(chain(*rows)))
            return
        with self._writing():
            self._database.executemany('INSERT INTO events VALUES (?, ?)', rows)

    def read(self, after: int = 0, most: int = -1) -> Iterator[Event]:
        """Yield the events with a seq greater than `after`, oldest first.

        :param most: so many at most; -1: all
        :raises JournalUnusable: the file is damaged
        """
        query = 'SELECT record FROM events WHERE seq > ? ORDER BY seq LIMIT ?'
        with unusable_otherwise(self._path):
            for (record,) in self._database.execute(query, (after, most)):
                yield from_record(json.loads(record))

    def first_seq(self) -> int:
        """Return the seq of the first event that is kept, or that is to come."""
        with unusable_otherwise(self._path):
            found = self._database.execute('SELECT min(seq) FROM events').fetchone()[0]
        if found is not None:
            return int(found)
        start = self.beginning()
        return start.seq + 1 if start else 1

    # --- states -----------------------------------------------------------------------------

    def snapshots(self) -> Iterator[Snapshot]:
        """Yield the states to start from, newest first."""
        return snapshots.sound_snapshots(self._database)

    def beginning(self) -> Snapshot | None:
        """Return the state before which events were removed, if some were.

        :raises JournalUnusable: it is damaged
        """
        with unusable_otherwise(self._path):
            return snapshots.beginning(self._database)

    def save(self, snapshot: Snapshot, ended: Sequence[JobRecord] = ()) -> None:
        """Keep a state to start from, and what is to stay of jobs that ended.

        :raises JournalFailed: neither is kept
        """
        rows = [(job.job, job.queued, json_of(job_to_plain(job))) for job in ended]
        with self._writing():
            snapshots.keep_snapshot(self._database, snapshot)
            self._database.executemany('INSERT OR REPLACE INTO jobs VALUES (?, ?, ?)', rows)

    # --- retention --------------------------------------------------------------------------

    def first_needed(self, live: Collection[str], keep_jobs: int) -> int:
        """Return the seq of the first event that must stay; 0: none has to go.

        :param live: jobs that have not ended
        :param keep_jobs: how many others keep their events, the last ones
        """
        with self._writing():
            return retention.first_needed(self._database, live, keep_jobs)

    def begin_with(self, snapshot: Snapshot) -> None:
        """Let replay begin with a state: events up to it may be removed.

        :raises JournalFailed: nothing has changed
        """
        with self._writing():
            snapshots.begin_with(self._database, snapshot)

    def remove_batch(self, before: int) -> bool:
        """Remove some of the first events before a seq, none that replay needs.

        :return: whether there are more
        :raises JournalFailed: none were removed
        """
        with self._writing():
            return retention.remove_batch(self._database, before)

    def close(self) -> None:
        """Close the file and let others have it."""
        self._database.close()
        self._lock.close()

    @contextmanager
    def _writing(self) -> Iterator[None]:
        with self._writable(), transaction(self._database):
            yield

    @contextmanager
    def _writable(self) -> Iterator[None]:
        try:
            self._be_writable()
            yield
        except sqlite3.Error as error:
            raise JournalFailed(f'the journal {self._path} cannot be written: {error}') from error

    def _be_writable(self) -> None:
        if not self._is_writable:
            database = _opened(self._path, self._synchronous)
            self._database.close()
            self._database = database
            self._is_writable = True


def _locked(path: Path) -> IO[str]:
    """Take the lock beside a journal."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        lock = path.with_name(path.name + '.lock').open('a+')
    except OSError as error:
        raise JournalUnusable(f'the journal {path} cannot be opened: {error.strerror}') from error
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        lock.seek(0)
        owner = lock.read().strip() or 'unknown'
        lock.close()
        raise JournalUnusable(
            f'the journal {path} is in use by another orchestrator (process {owner}); stop that '
            'one, or name another file'
        ) from None
    _sign(lock)
    return lock


def _sign(lock: IO[str]) -> None:
    """Say who has the lock, for people; it holds even where that cannot be written."""
    try:
        lock.truncate(0)
        lock.write(f'{os.getpid()}\n')
        lock.flush()
    except OSError:
        pass


def _found(path: Path) -> sqlite3.Connection | None:
    """Open a journal of today for reading; None: it has to be made, or to be brought up to date.

    :raises JournalUnusable: it is not ours, newer, or may not be written; an older one: damaged
    """
    if not path.exists() or not path.stat().st_size:
        return None
    if not (os.access(path, os.R_OK | os.W_OK) and os.access(path.parent, os.W_OK)):
        raise JournalUnusable(f'the journal {path} cannot be opened: {os.strerror(errno.EACCES)}')
    database = unchanging(path)
    try:
        version = schema_of(database, path)
        if version == SCHEMA:
            return database
        # An older one is about to be changed, which takes longer than looking at all of it.
        (found,) = database.execute('PRAGMA quick_check(1)').fetchone()
        if found != 'ok':
            raise JournalUnusable(f'the journal {path} cannot be used: {found}')
    except BaseException:
        database.close()
        raise
    database.close()
    return None


def _opened(path: Path, synchronous: str) -> sqlite3.Connection:
    """Open a journal for writing, of today's schema from here on."""
    database = sqlite3.connect(path, isolation_level=None, timeout=10.0)
    try:
        version = schema_of(database, path)
        database.execute('PRAGMA journal_mode = WAL')
        database.execute(f'PRAGMA synchronous = {synchronous}')
        if version < SCHEMA:
            bring_up_to_date(database, version)
    except BaseException:
        database.close()
        raise
    return database
