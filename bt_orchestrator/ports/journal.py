"""The journal as its only writer sees it."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from typing import NamedTuple, Protocol

from bt_orchestrator.model.books import Books
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.jobs.job_record import JobRecord
from bt_orchestrator.model.judging.used_ids import SealedIds


class Snapshot(NamedTuple):
    """The state after an event."""

    seq: int
    stamp: str
    """Program and cell that it was written by and for."""
    state: str
    """As JSON."""


class EventStore(Protocol):
    """The journal: the only durable truth."""

    @property
    def history(self) -> str:
        """Return the id of the history of the events: random, unique to this journal.

        Event numbers are valid only within one history.
        """

    @property
    def is_restored(self) -> bool:
        """Tell whether this history continues a copy of another one (semantics 9.2)."""

    def missing(self, after: int) -> str:
        """Say what was written after an event and is lost; empty: nothing.

        :raises JournalUnusable: it cannot be read
        """

    def go_on_after(self, seq: int) -> None:
        """Begin a new history after an event, with the next `append`.

        Others have seen the lost events under their numbers, which new events now reuse.
        """

    def append(self, events: Sequence[Event]) -> None:
        """Make the events durable, all or none.

        :param events: one or more. Their numbers follow the last event without a gap; the first
            number of a new journal is 1, that of a new history follows `go_on_after`
        :raises JournalFailed: none of them is durable, or the numbers are not the next ones
        """

    def read(self, after: int = 0, most: int = -1) -> Iterable[Event]:
        """Return the events with a seq greater than `after`, oldest first.

        Errors are raised when the iteration reaches them.

        :param most: so many at most; -1: all
        :raises DamagedRecord: the next one cannot be read; those before it are intact
        :raises JournalUnusable: nothing more can be read
        """

    def first_seq(self) -> int:
        """Return the seq of the first event that is kept; if none is, of the next one.

        :raises JournalUnusable: it cannot be read
        """

    def snapshots(self) -> Iterable[Snapshot]:
        """Return states to start from, newest first. Each is a cache and may be ignored."""

    def beginning(self) -> Snapshot | None:
        """Return the state that replay begins with; None: it begins with the first event.

        :raises JournalUnusable: it is damaged, or cannot be read
        """

    def used_ids(self, digest: str) -> str | None:
        """Return a part of the ids that were ever used, which a state names; None: it is lost."""


class Journal(EventStore, Protocol):
    """A journal that outlives its process, and is kept short for the next start."""

    @property
    def is_shared(self) -> bool:
        """Tell whether another machine can go on with it: then a node that cannot write ends."""

    def save(self, snapshot: Snapshot, ended: Sequence[JobRecord] = ()) -> None:
        """Store a state to start from, and the summaries of jobs that ended.

        The parts of used ids that the state names are stored before (`keep_used`).

        :raises JournalFailed: neither is stored
        """

    def lacking(self, parts: Iterable[SealedIds]) -> Sequence[SealedIds]:
        """Return the parts of used ids that are not known to be in it, whole. Reads nothing."""

    def keep_used(self, part: SealedIds) -> None:
        """Store a part of used ids. It stays.

        :raises JournalFailed: it is not stored
        """

    def first_needed(self, live: Collection[str], keep_jobs: int) -> int:
        """Return the seq of the first event of any live job, or of the last `keep_jobs` others.

        0: there are no more jobs than that.

        :raises JournalFailed: it cannot be read
        """

    def begin_with(self, snapshot: Snapshot) -> None:
        """Make replay begin with a state: events up to it may be removed.

        :raises JournalFailed: nothing has changed
        """

    def booked(self) -> int:
        """Return the seq of the last event that is in books; 0: none is, or it cannot be read."""

    def keep_books(self, made: Books) -> None:
        """Store books: the account of some events, which outlives them.

        :raises JournalFailed: nothing has changed
        """

    def remove_batch(self, before: int) -> bool:
        """Remove some of the first events before a seq, none that replay needs.

        :return: whether there are more
        :raises JournalFailed: none were removed
        """

    def close(self) -> None:
        """Close it and release its lock."""
