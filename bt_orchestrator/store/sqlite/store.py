"""The durable journal: an SQLite file (semantics 9.1)."""

from __future__ import annotations

import logging
import sqlite3
from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from uuid import uuid4

from bt_orchestrator.errors import JournalFailed, JournalUnusable
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.jobs.job_record import JobRecord
from bt_orchestrator.ports import Snapshot
from bt_orchestrator.store.sqlite import opening, retention, rows, snapshots, summaries
from bt_orchestrator.store.sqlite.database import (
    has_log,
    log_size,
    transaction,
    unchanging,
    unusable_otherwise,
)
from bt_orchestrator.store.sqlite.files_in_use import FilesInUse
from bt_orchestrator.store.sqlite.keeping import aside_of, keep_aside, readable_by_others
from bt_orchestrator.store.sqlite.mark import Mark, Reached
from bt_orchestrator.store.sqlite.schema import (
    History,
    begin_history,
    begin_to_write,
    end_to_write,
    history_of,
    kept_from,
)
from bt_orchestrator.store.sqlite.shortfall import cut_off, is_cut_off, shortfall

log = logging.getLogger(__name__)

_EVERY = 1 << 62
"""Greater than the seq of any event."""

SYNCHRONOUS = ('FULL', 'NORMAL')

PATIENCE_AT_THE_END_MS = 1000
"""So long a node that ends waits for another program that keeps the file locked."""


class SqliteStore:
    """A journal in a file. Implements `ports.Journal`.

    One transaction an append, in WAL mode, so that others may read while it is written. A lock on
    a file beside it keeps a second orchestrator out for as long as this one lives, and is gone
    when its process is, however that ends.

    A file is only read until the first write: whoever refuses what is in it has changed nothing.

    From then on it is read by another connection than it is written by, so that one thread may
    read while another one writes; the first write has to end before.
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
        self._lock = opening.take_lock(path)
        self._files: FilesInUse | None = None
        """None: it is only read so far."""
        self._end = _EVERY
        """What stands after this event is not read, and removed with the first write."""
        self._is_said_unclosed = False
        """The file itself says that a node writes it, and not its log alone."""
        self._mark = Mark(path)
        try:
            with unusable_otherwise(path):
                found = opening.to_read(path, self._mark.found)
                self._database = found or opening.to_write(path, synchronous)
                self._reading = self._database if found else opening.beside_writer(path)
                self._history = self._on_file = history_of(self._database)
                self._is_cut_off = (
                    found is not None and self._mark.found is None and is_cut_off(found, path)
                )
                if found is None:
                    self._is_said_unclosed = begin_to_write(self._database)
                    self._files = FilesInUse(path, lambda: log_size(self._database))
                wide = readable_by_others(path)
        except BaseException:
            self._lock.close()
            raise
        if wide:
            log.warning('%s; is that so on purpose? chmod 600 %s*', wide, path)

    @property
    def history(self) -> str:
        """Return the name that no other journal has."""
        return self._history.id

    @property
    def is_restored(self) -> bool:
        """Tell whether the journal goes on from a copy that was brought back."""
        return self._history.is_restored

    # --- events -----------------------------------------------------------------------------

    def append(self, events: Sequence[Event]) -> None:
        """Make the events durable, all or none.

        :raises JournalFailed: they are not; nothing of them is in the journal
        """
        with self._writable():
            if self._history == self._on_file:
                rows.add(self._database, events)
            else:
                self._append_to_a_new_history(events)
        self._mark.write(Reached(self.history, events[-1].seq, events[-1].time))

    def read(self, after: int = 0, most: int = -1) -> Iterator[Event]:
        """Yield the events with a seq greater than `after`, oldest first.

        :param most: so many at most; -1: all
        :raises DamagedRecord: the next one cannot be read; those before it are as they were
        :raises JournalUnusable: the file is damaged
        """
        with unusable_otherwise(self._path):
            before = max(after, self.first_seq() - 1)
            yield from rows.events_of(self._rows(after, most), before, self._on_file.checked_from)

    def _rows(self, after: int, most: int) -> Iterator[rows.Row]:
        while page := rows.page(self._reading, after, self._end, most):
            yield from page
            after = page[-1].seq
            most -= len(page) if most > 0 else 0

    def missing(self, after: int) -> str:
        """Tell, in words, what was written after an event and is not to be had; empty: nothing."""
        with unusable_otherwise(self._path):
            last = rows.last_seq(self._reading)
        found = shortfall(self._mark, self._on_file.id, last, after)
        return found or (cut_off(self._path, last) if self._is_cut_off else '')

    def go_on_after(self, seq: int) -> None:
        """Let a history of its own begin after an event.

        If events stand after it, or a log that SQLite cannot read to its end, the files are first
        kept under another name, as they are.
        """
        self._history = History(uuid4().hex, False, self._on_file.checked_from)
        self._end = seq
        if self._files is not None:  # it was brought up to date
            self._only_read_again()

    def first_seq(self) -> int:
        """Return the seq of the first event that retention has left, or that is to come."""
        with unusable_otherwise(self._path):
            return kept_from(self._reading)

    # --- states -----------------------------------------------------------------------------

    def snapshots(self) -> Iterator[Snapshot]:
        """Yield the states to start from, newest first."""
        for seq in snapshots.kept(self._reading):
            found = snapshots.sound_snapshot(self._reading, seq) if seq <= self._end else None
            if found is not None:
                yield found

    def beginning(self) -> Snapshot | None:
        """Return the state before which events were removed, if some were.

        :raises JournalUnusable: it is damaged
        """
        with unusable_otherwise(self._path):
            return snapshots.beginning(self._reading)

    def save(self, snapshot: Snapshot, ended: Sequence[JobRecord] = ()) -> None:
        """Keep a state to start from, and what is to stay of jobs that ended.

        :raises JournalFailed: neither is kept
        """
        with self._writable():
            self._is_said_unclosed = self._is_said_unclosed or begin_to_write(self._database)
        with self._writing():
            snapshots.keep_snapshot(self._database, snapshot)
            summaries.keep(self._database, ended)
        self._mark.sync()

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
        if self._files is not None:
            self._say_closed(self._files)
        self._reading.close()
        self._database.close()
        self._mark.close()
        if self._files is not None:
            self._files.release()
        self._lock.close()

    def _say_closed(self, files: FilesInUse) -> None:
        """Say in the file that everything is in it, if that is so."""
        try:
            files.check()
            self._database.execute(f'PRAGMA busy_timeout = {PATIENCE_AT_THE_END_MS}')
            end_to_write(self._database)
        except (sqlite3.Error, JournalUnusable) as error:
            log.warning('the journal %s is left as one that was not closed: %s', self._path, error)

    @contextmanager
    def _writing(self) -> Iterator[None]:
        with self._writable(), transaction(self._database):
            yield

    @contextmanager
    def _writable(self) -> Iterator[None]:
        try:
            files = self._files or self._begin_to_write()
            files.check()
            yield
            files.check()
        except (sqlite3.Error, JournalUnusable) as error:
            raise JournalFailed(f'the journal {self._path} cannot be written: {error}') from error

    def _append_to_a_new_history(self, events: Sequence[Event]) -> None:
        with transaction(self._database):
            rows.remove_after(self._database, self._end)
            begin_history(self._database, self.history)
            rows.add(self._database, events)
        self._on_file, self._end = self._history, _EVERY

    def _begin_to_write(self) -> FilesInUse:
        """Open for writing what was only read so far.

        First close, then open: a process that closes any descriptor of a file loses all its locks
        on that file, and the next program that looks into the journal takes the log away.
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
        """See that nobody wrote between the two connections.

        :raises JournalUnusable: what was read is not what is there
        """
        found = rows.last_seq(self._database)
        if history_of(self._database) != self._on_file:
            raise JournalUnusable('another journal has taken its place since it was read')
        if found != read:
            raise JournalUnusable(
                f'it ended with event {read} when it was read, and ends with event {found} now; '
                'another program writes it'
            )

    def _only_read_again(self) -> None:
        self._reading.close()
        self._database.close()
        if self._files is not None:
            self._files.release()
            self._files = None
        self._database = self._reading = unchanging(self._path)
