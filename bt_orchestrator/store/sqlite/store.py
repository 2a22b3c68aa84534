"""The durable journal: an SQLite file (semantics 9.1)."""

from __future__ import annotations

import logging
import sqlite3
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from itertools import chain
from pathlib import Path

from bt_orchestrator.base.errors import JournalFailed, JournalUnusable
from bt_orchestrator.model.codec import to_text
from bt_orchestrator.model.events import Event, JobQueued
from bt_orchestrator.model.jobs.job_record import JobRecord
from bt_orchestrator.ports import Snapshot
from bt_orchestrator.store.sequence import refuse_gap
from bt_orchestrator.store.shared import rows
from bt_orchestrator.store.shared.database import Database, check_of_event, history_of
from bt_orchestrator.store.shared.journal import EVERY, KeptJournal
from bt_orchestrator.store.shared.mark import Mark, Reached
from bt_orchestrator.store.sqlite import opening
from bt_orchestrator.store.sqlite.database import (
    has_log,
    log_size,
    transaction,
    unchanging,
    unusable_otherwise,
)
from bt_orchestrator.store.sqlite.keeping import (
    FilesInUse,
    aside_of,
    keep_aside,
    readable_by_others,
)
from bt_orchestrator.store.sqlite.opening import cut_off, is_cut_off
from bt_orchestrator.store.sqlite.schema import begin_to_write, end_to_write

log = logging.getLogger(__name__)

FAILURES = sqlite3.Error, OSError, JournalUnusable
"""Raised by a write of the file."""

SYNCHRONOUS = ('FULL', 'NORMAL')

_AT_ONCE = 50
"""Most events that are written with one statement; a settle has a few."""

_INSERT = 'INSERT INTO events (seq, record, checksum, ends) VALUES '
_ONE = '(?, ?, ?, ?)'
_STATEMENTS = [_INSERT + ', '.join([_ONE] * number) for number in range(_AT_ONCE + 1)]
"""For so many events; made once, as SQLite's driver looks a statement up by its text."""

PATIENCE_AT_THE_END_MS = 1000
"""How long an ending node waits for another program that keeps the file locked."""


class SqliteStore(KeptJournal):
    """A journal in a file. Implements `ports.Journal`.

    One transaction per append, in WAL mode, so that others may read while it is written. A lock on
    a file beside it keeps a second orchestrator out; it is released when the process ends, for
    whatever reason.

    A file is only read until the first write: a refusal of its content changes nothing. After
    that, separate connections read and write, so that one thread may read while another one
    writes; the first write has to end before.
    """

    _reading: sqlite3.Connection

    def __init__(self, path: Path, *, synchronous: str = 'FULL') -> None:
        """Open or create a journal; an older one is upgraded.

        :param synchronous: FULL (a power cut loses nothing) or NORMAL (it may lose the last
            events; a crash of the program loses nothing)
        :raises JournalUnusable: it is in use, not ours, newer, damaged, or cannot be written
        """
        if synchronous not in SYNCHRONOUS:
            known = ' or '.join(SYNCHRONOUS)
            raise JournalUnusable(f'a journal is written with {known}; found {synchronous!r}')
        self._path = path
        self._synchronous = synchronous
        self._lock = opening.take_lock(path)
        super().__init__(Mark(path))
        self._files: FilesInUse | None = None
        """None: only read so far."""
        self._is_said_unclosed = False
        """The file itself, not only its log, is marked as being written."""
        try:
            with unusable_otherwise(path):
                connection = opening.to_read(path, self._mark.found)
                self._database = connection or opening.to_write(path, synchronous)
                self._reading = self._database if connection else opening.beside_writer(path)
                self._history = self._on_file = history_of(self._database)
                self._is_cut_off = (
                    connection is not None
                    and self._mark.found is None
                    and is_cut_off(connection, path)
                )
                if connection is None:
                    self._is_said_unclosed = begin_to_write(self._database)
                    self._files = FilesInUse(path, lambda: log_size(self._database))
                wide = readable_by_others(path)
        except BaseException:
            self._lock.close()
            raise
        if wide:
            log.warning('%s; is that so on purpose? chmod 600 %s*', wide, path)

    def append(self, events: Sequence[Event]) -> None:
        """Make the events durable, all or none.

        :raises JournalFailed: none of them is in the journal
        """
        try:  # not in `_writable`: its generator takes a fifteenth of the time
            files = self._files or self._begin_to_write()
            files.check_sizes()
            refuse_gap(events, self._followed_by(self._database, events[0].seq))
            if self._history == self._on_file:
                waits = self._synchronous == 'FULL'
                _add(self._database, events, self.at_disk if waits else None)
            else:
                self._append_to_a_new_history(events)
            self._last = events[-1].seq
            files.check()
        except FAILURES as error:
            raise self._failed(error) from error
        self._mark.write(Reached(self.history, events[-1].seq, events[-1].time))

    def go_on_after(self, seq: int) -> None:
        """Begin a new history after an event.

        If there are events after it, or a log that SQLite cannot read to its end, the files are
        first copied to another name.
        """
        super().go_on_after(seq)
        if self._files is not None:  # it was upgraded
            self._only_read_again()

    def _cut_off(self, last: int) -> str:
        return cut_off(self._path, last) if self._is_cut_off else ''

    def save(self, snapshot: Snapshot, ended: Sequence[JobRecord] = ()) -> None:
        """Store a state to start from, and the summaries of jobs that ended.

        :raises JournalFailed: neither is stored
        """
        with self._writable():
            self._is_said_unclosed = self._is_said_unclosed or begin_to_write(self._database)
        super().save(snapshot, ended)

    def take(self, database: Database, page: Sequence[rows.Row]) -> None:
        """Write rows of events of another journal unchanged."""
        database.executemany(
            _INSERT + _ONE,
            [
                (row.seq, row.text.decode(), check_of_event(row.seq, row.text, ends), ends)
                for row in page
                for ends in [1 if row.ends is None else row.ends]
            ],
        )

    def close(self) -> None:
        """Close the file and release the lock."""
        if self._files is not None:
            self._say_closed(self._files)
        self._reading.close()
        self._database.close()
        self._mark.close()
        if self._files is not None:
            self._files.release()
        self._lock.close()

    def _say_closed(self, files: FilesInUse) -> None:
        """Mark the file as closed, if everything is in it."""
        try:
            files.check()
            self._database.execute(f'PRAGMA busy_timeout = {PATIENCE_AT_THE_END_MS}')
            end_to_write(self._database)
        except FAILURES as error:
            log.warning('the journal %s is left as one that was not closed: %s', self._path, error)

    @contextmanager
    def writing(self) -> Iterator[sqlite3.Connection]:
        with self._writable(), transaction(self._database):
            yield self._database

    @contextmanager
    def looking(self) -> Iterator[sqlite3.Connection]:
        with unusable_otherwise(self._path):
            yield self._reading

    @contextmanager
    def _writable(self) -> Iterator[None]:
        try:
            files = self._files or self._begin_to_write()
            files.check_sizes()
            yield
            files.check()
        except FAILURES as error:
            raise self._failed(error) from error

    def _failed(self, error: Exception) -> JournalFailed:
        return JournalFailed(f'the journal {self._path} cannot be written: {error}')

    def _append_to_a_new_history(self, events: Sequence[Event]) -> None:
        with transaction(self._database):
            rows.remove_after(self._database, self._end)
            self.name_history(self._database, self.history)
            _add(self._database, events)
        self._on_file, self._end = self._history, EVERY

    def _begin_to_write(self) -> FilesInUse:
        """Open the journal for writing.

        First close, then open: a process that closes any descriptor of a file loses all its locks
        on that file, and then the next reader of the journal would remove the log.
        """
        read = rows.last_seq(self._database)
        self._database.close()
        try:
            if self._history != self._on_file and (read > self._end or has_log(self._path)):
                keep_aside(self._path, aside_of(self._path, 'damaged'))
            self._database = opening.to_write(self._path, self._synchronous)
            self._refuse_another_end(read)
            self._is_said_unclosed = begin_to_write(self._database)
            self._reading = opening.beside_writer(self._path)
            self._files = FilesInUse(self._path, lambda: log_size(self._database))
        except BaseException:
            self._only_read_again()
            raise
        return self._files

    def _refuse_another_end(self, read: int) -> None:
        """Check that nothing was written between the two connections.

        :raises JournalUnusable: the file is not what was read
        """
        end = rows.last_seq(self._database)
        if history_of(self._database) != self._on_file:
            raise JournalUnusable('another journal has taken its place since it was read')
        if end != read:
            raise JournalUnusable(
                f'it ended with event {read} when it was read, and ends with event {end} now; '
                'another program writes it'
            )

    def _only_read_again(self) -> None:
        self._reading.close()
        self._database.close()
        if self._files is not None:
            self._files.release()
            self._files = None
        self._database = self._reading = unchanging(self._path)


def _add(
    database: sqlite3.Connection,
    events: Sequence[Event],
    at_disk: Callable[[], None] | None = None,
) -> None:
    """Write the events of one commit, all or none.

    In a transaction of its own, unless one is open.

    :param at_disk: called before a statement that waits for the disk and does little else
    """
    rows = [_row(event, 0) for event in events[:-1]] + [_row(event, 1) for event in events[-1:]]
    queued = [(event.seq, event.job) for event in events if type(event) is JobQueued]
    if len(rows) <= _AT_ONCE and not queued:  # one statement is a transaction, and takes less time
        values = tuple(chain(*rows))
        if at_disk is not None:
            at_disk()
        database.execute(_STATEMENTS[len(rows)], values)
    elif database.in_transaction:
        _add_each(database, rows, queued)
    else:
        with transaction(database):
            _add_each(database, rows, queued)


def _add_each(
    database: sqlite3.Connection,
    rows: Sequence[tuple[int, str, int, int]],
    queued: Sequence[tuple[int, str]],
) -> None:
    database.executemany(_INSERT + _ONE, rows)
    database.executemany('INSERT INTO queued VALUES (?, ?)', queued)


def _row(event: Event, ends: int) -> tuple[int, str, int, int]:
    text = to_text(event)
    return event.seq, text, check_of_event(event.seq, text.encode(), ends), ends
