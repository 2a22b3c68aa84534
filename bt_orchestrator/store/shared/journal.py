"""The functions of a journal in any database that speaks SQL; each store adds its writing."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager
from uuid import uuid4

from bt_orchestrator.base.errors import JournalFailed
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.jobs.job_record import JobRecord
from bt_orchestrator.model.judging.used_ids import SealedIds
from bt_orchestrator.model.keeping.books import Books
from bt_orchestrator.model.uptime import ClockReading
from bt_orchestrator.ports import Snapshot
from bt_orchestrator.store.shared import books, rows, snapshots
from bt_orchestrator.store.shared.database import (
    Check,
    Database,
    History,
    begin_history,
    check_of_event,
    kept_from,
)
from bt_orchestrator.store.shared.mark import Mark, Reached, shortfall

EVERY = 1 << 62
"""Greater than the seq of any event."""


def _not_set() -> None:
    """Stand for what the user of the journal sets."""


class KeptJournal(ABC):
    """A journal in a database: all of `ports.Journal` but `append` and `close`.

    One connection reads, and another one may write meanwhile in another thread.
    """

    is_shared = False
    epoch = 0
    alone_from_s = 0.0
    patience_s = 0.0
    """How long a write may take, where that depends on others."""
    at_disk: Callable[[], None] = staticmethod(_not_set)
    _reading: Database
    check: Check = staticmethod(check_of_event)

    def __init__(self, mark: Mark) -> None:
        """Begin without any history.

        :param mark: how far this machine has written the journal
        """
        self._mark = mark
        self._history = self._on_file = History('', False)
        """The history of the next event, and of the events that are there."""
        self._end = EVERY
        """Rows after this event are not read, and are removed with the first write."""
        self._last: int | None = None
        """The last event in it; None: not looked up yet, which is before the first write."""
        self._sound_ids: set[str] = set()
        """Parts of used ids that were read or written, and are whole."""

    @abstractmethod
    def writing(self) -> AbstractContextManager[Database]:
        """Commit all of what is done in this context, or nothing.

        :raises JournalFailed: nothing
        """

    @abstractmethod
    def take(self, database: Database, page: Sequence[rows.Row]) -> None:
        """Write rows of events of another journal unchanged, with checks of this one."""

    @abstractmethod
    def looking(self) -> AbstractContextManager[Database]:
        """Read in this context.

        :raises JournalUnusable: it cannot be read, or what was read makes no sense
        """

    @property
    def history(self) -> str:
        """Return the unique id of the history."""
        return self._history.id

    @property
    def is_restored(self) -> bool:
        """Tell whether the journal continues from a restored copy."""
        return self._history.is_restored

    def name_history(self, database: Database, history: str, *, restored: bool = False) -> None:
        """Give the journal the id of another history.

        :param restored: it continues from a copy
        """
        begin_history(database, history, restored=restored)

    def note(self, reached: Reached) -> None:
        """Note how far it was written on this machine."""
        self._mark.write(reached)
        self._mark.sync()

    # --- events -----------------------------------------------------------------------------

    def read(self, after: int = 0, most: int = -1) -> Iterator[Event]:
        """Yield the events with a seq greater than `after`, oldest first.

        :param most: maximum number; -1: all
        :raises DamagedRecord: the next one cannot be read; those before it are intact
        :raises JournalUnusable: it cannot be read
        """
        with self.looking() as database:
            before = max(after, kept_from(database) - 1)
            yield from rows.events_of(
                self._rows(after, most), before, self._on_file.checked_from, self.check
            )

    def _rows(self, after: int, most: int) -> Iterator[rows.Row]:
        while page := rows.page(self._reading, after, self._end, most):
            yield from page
            after = page[-1].seq
            most -= len(page) if most > 0 else 0

    def missing(self, after: int) -> str:
        """Say what was written after an event and is lost; empty: nothing."""
        with self.looking() as database:
            last = rows.last_seq(database)
        return shortfall(self._mark, self._on_file.id, last, after) or self._cut_off(last)

    def _cut_off(self, last: int) -> str:  # noqa: ARG002 - a store may know
        """Say that events may be missing, though this machine does not know the last one."""
        return ''

    def go_on_after(self, seq: int) -> None:
        """Begin a new history after an event."""
        self._history = History(uuid4().hex, False, self._on_file.checked_from)
        self._end = self._last = seq

    def may_command(self) -> bool:
        """Tell whether a goal may be sent at this moment: a lock keeps every other writer out."""
        return True

    def renew(self) -> None:  # noqa: B027 - a store may have others beside it
        """Do nothing: the lock of a file lives as long as its process."""

    def absent_at(self, seq: int) -> ClockReading | None:  # noqa: ARG002 - a store may know
        """Return a moment at which an event was not yet in the journal; None: not known."""
        return None

    def first_seq(self) -> int:
        """Return the seq of the first event that retention has left; if none, of the next one."""
        with self.looking() as database:
            return kept_from(database)

    # --- states -----------------------------------------------------------------------------

    def snapshots(self) -> Iterator[Snapshot]:
        """Yield the states to start from, newest first."""
        for seq in snapshots.kept(self._reading):
            snapshot = snapshots.sound_snapshot(self._reading, seq) if seq <= self._end else None
            if snapshot is not None:
                yield snapshot

    def beginning(self) -> Snapshot | None:
        """Return the state after the removed events, if some were removed.

        :raises JournalUnusable: it is damaged
        """
        with self.looking() as database:
            return snapshots.beginning(database)

    def save(self, snapshot: Snapshot, ended: Sequence[JobRecord] = ()) -> None:
        """Store a state to start from, and the summaries of jobs that ended.

        :raises JournalFailed: neither is stored
        """
        with self.writing() as database:
            snapshots.keep_snapshot(database, snapshot)
            rows.keep_summaries(database, ended)
        self._mark.sync()

    def used_ids(self, digest: str) -> str | None:
        """Return a part of the ids that were ever used; None: it is lost."""
        sound = snapshots.sound_copies(self._reading, digest)
        if len(sound) == len(snapshots.COPIES):
            self._sound_ids.add(digest)
        return sound[0] if sound else None

    def lacking(self, parts: Iterable[SealedIds]) -> list[SealedIds]:
        """Return the parts that are not known to be in it, whole."""
        return [part for part in parts if part.digest not in self._sound_ids]

    def keep_used(self, part: SealedIds) -> None:
        """Store a part of the ids that were ever used, for the states that name it.

        :raises JournalFailed: it is not stored
        """
        with self.writing() as database:
            snapshots.keep_ids(database, part)
        self._sound_ids.add(part.digest)

    # --- retention --------------------------------------------------------------------------

    def first_needed(self, live: Collection[str], keep_jobs: int) -> int:
        """Return the seq of the first event that must stay; 0: none has to go.

        :param live: jobs that have not ended
        :param keep_jobs: how many others keep their events, the last ones
        """
        with self.writing() as database:
            return rows.first_needed(database, live, keep_jobs)

    def begin_with(self, snapshot: Snapshot) -> None:
        """Make replay begin with a state: events up to it may be removed.

        :raises JournalFailed: nothing has changed
        """
        with self.writing() as database:
            snapshots.begin_with(database, snapshot)

    def booked(self) -> int:
        """Return the seq of the last event that is in books; 0: none is, or it cannot be read."""
        return min(books.reached(self._reading), self._end)

    def keep_books(self, made: Books) -> None:
        """Store books.

        :raises JournalFailed: nothing has changed
        """
        if made.history != self._on_file.id:
            raise JournalFailed('the books are of another history than the journal')
        with self.writing() as database:
            books.keep(database, made)

    def remove_batch(self, before: int) -> bool:
        """Remove some of the first events before a seq, none that replay needs.

        :return: whether there are more
        :raises JournalFailed: none were removed
        """
        with self.writing() as database:
            return rows.remove_batch(database, before)

    def _followed_by(self, database: Database, seq: int) -> int:
        """Return the last event: of the rows, or of a state that outlived the rows before it."""
        if self._last is not None:
            return self._last
        last = max(rows.last_seq(database), kept_from(database) - 1)
        is_after_state = seq - 1 > last and seq - 1 in snapshots.kept(database)
        return seq - 1 if is_after_state else last
