"""The durable journal: an SQLite file (semantics 9.1)."""

from __future__ import annotations

import logging
import sqlite3
from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from uuid import uuid4

from bt_orchestrator.base.errors import JournalFailed, JournalUnusable
from bt_orchestrator.model.books import Books
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.jobs.job_record import JobRecord
from bt_orchestrator.model.judging.sealed_ids import SealedIds
from bt_orchestrator.ports import Snapshot
from bt_orchestrator.store.sequence import refuse_gap
from bt_orchestrator.store.sqlite import (
    books,
    opening,
    retention,
    rows,
    snapshots,
    summaries,
    used_ids,
)
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
"""How long an ending node waits for another program that keeps the file locked."""


class SqliteStore:
    """A journal in a file. Implements `ports.Journal`.

    One transaction per append, in WAL mode, so that others may read while it is written. A lock on
    a file beside it keeps a second orchestrator out; it is released when the process ends, for
    whatever reason.

    A file is only read until the first write: a refusal of its content changes nothing. After
    that, separate connections read and write, so that one thread may read while another one
    writes; the first write has to end before.
    """

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
        self._files: FilesInUse | None = None
        """None: only read so far."""
        self._end = _EVERY
        """Rows after this event are not read, and are removed with the first write."""
        self._last: int | None = None
        """The last event in it; None: not looked up yet, which is before the first write."""
        self._is_said_unclosed = False
        """The file itself, not only its log, is marked as being written."""
        self._sound_ids: set[str] = set()
        """Parts of used ids that were read or written, and are whole."""
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
        """Return the unique id of the history."""
        return self._history.id

    @property
    def is_restored(self) -> bool:
        """Tell whether the journal continues from a restored copy."""
        return self._history.is_restored

    # --- events -----------------------------------------------------------------------------

    def append(self, events: Sequence[Event]) -> None:
        """Make the events durable, all or none.

        :raises JournalFailed: none of them is in the journal
        """
        with self._writable():
            last = self._followed_by(events[0].seq) if self._last is None else self._last
            refuse_gap(events, last)
            if self._history == self._on_file:
                rows.add(self._database, events)
            else:
                self._append_to_a_new_history(events)
            self._last = events[-1].seq
        self._mark.write(Reached(self.history, events[-1].seq, events[-1].time))

    def read(self, after: int = 0, most: int = -1) -> Iterator[Event]:
        """Yield the events with a seq greater than `after`, oldest first.

        :param most: maximum number; -1: all
        :raises DamagedRecord: the next one cannot be read; those before it are intact
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
        """Say what was written after an event and is lost; empty: nothing."""
        with unusable_otherwise(self._path):
            last = rows.last_seq(self._reading)
        found = shortfall(self._mark, self._on_file.id, last, after)
        return found or (cut_off(self._path, last) if self._is_cut_off else '')

    def go_on_after(self, seq: int) -> None:
        """Begin a new history after an event.

        If there are events after it, or a log that SQLite cannot read to its end, the files are
        first copied to another name.
        """
        self._history = History(uuid4().hex, False, self._on_file.checked_from)
        self._end = self._last = seq
        if self._files is not None:  # it was upgraded
            self._only_read_again()

    def first_seq(self) -> int:
        """Return the seq of the first event that retention has left; if none, of the next one."""
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
        """Return the state after the removed events, if some were removed.

        :raises JournalUnusable: it is damaged
        """
        with unusable_otherwise(self._path):
            return snapshots.beginning(self._reading)

    def save(self, snapshot: Snapshot, ended: Sequence[JobRecord] = ()) -> None:
        """Store a state to start from, and the summaries of jobs that ended.

        :raises JournalFailed: neither is stored
        """
        with self._writable():
            self._is_said_unclosed = self._is_said_unclosed or begin_to_write(self._database)
        with self._writing():
            snapshots.keep_snapshot(self._database, snapshot)
            summaries.keep(self._database, ended)
        self._mark.sync()

    def used_ids(self, digest: str) -> str | None:
        """Return a part of the ids that were ever used; None: it is lost."""
        sound = used_ids.sound_copies(self._reading, digest)
        if len(sound) == len(used_ids.COPIES):
            self._sound_ids.add(digest)
        return sound[0] if sound else None

    def lacking(self, parts: Iterable[SealedIds]) -> list[SealedIds]:
        """Return the parts that are not known to be in it, whole."""
        return [part for part in parts if part.digest not in self._sound_ids]

    def keep_used(self, part: SealedIds) -> None:
        """Store a part of the ids that were ever used, for the states that name it.

        :raises JournalFailed: it is not stored
        """
        with self._writing():
            used_ids.keep(self._database, part)
        self._sound_ids.add(part.digest)

    # --- retention --------------------------------------------------------------------------

    def first_needed(self, live: Collection[str], keep_jobs: int) -> int:
        """Return the seq of the first event that must stay; 0: none has to go.

        :param live: jobs that have not ended
        :param keep_jobs: how many others keep their events, the last ones
        """
        with self._writing():
            return retention.first_needed(self._database, live, keep_jobs)

    def begin_with(self, snapshot: Snapshot) -> None:
        """Make replay begin with a state: events up to it may be removed.

        :raises JournalFailed: nothing has changed
        """
        with self._writing():
            snapshots.begin_with(self._database, snapshot)

    def booked(self) -> int:
        """Return the seq of the last event that is in books; 0: none is, or it cannot be read."""
        return min(books.reached(self._reading), self._end)

    def keep_books(self, made: Books) -> None:
        """Store books.

        :raises JournalFailed: nothing has changed
        """
        if made.history != self._on_file.id:
            raise JournalFailed('the books are of another history than the journal')
        with self._writing():
            books.keep(self._database, made)

    def remove_batch(self, before: int) -> bool:
        """Remove some of the first events before a seq, none that replay needs.

        :return: whether there are more
        :raises JournalFailed: none were removed
        """
        with self._writing():
            return retention.remove_batch(self._database, before)

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
        except (sqlite3.Error, OSError, JournalUnusable) as error:
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
        except (sqlite3.Error, OSError, JournalUnusable) as error:
            raise JournalFailed(f'the journal {self._path} cannot be written: {error}') from error

    def _append_to_a_new_history(self, events: Sequence[Event]) -> None:
        with transaction(self._database):
            rows.remove_after(self._database, self._end)
            begin_history(self._database, self.history)
            rows.add(self._database, events)
        self._on_file, self._end = self._history, _EVERY

    def _followed_by(self, seq: int) -> int:
        """Return the last event: of the rows, or of a state that outlived the rows before it."""
        last = max(rows.last_seq(self._database), kept_from(self._database) - 1)
        is_after_state = seq - 1 > last and seq - 1 in snapshots.kept(self._database)
        return seq - 1 if is_after_state else last

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
