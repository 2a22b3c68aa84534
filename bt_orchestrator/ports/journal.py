"""The journal as its only writer sees it."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from typing import NamedTuple, Protocol

from bt_orchestrator.model.events import Event
from bt_orchestrator.model.jobs.job_record import JobRecord
from bt_orchestrator.model.judging.used_ids import SealedIds
from bt_orchestrator.model.keeping.books import Books
from bt_orchestrator.model.uptime import ClockReading


class Snapshot(NamedTuple):
    """The state after an event."""

    seq: int
    stamp: str
    """Program and cell that it was written by and for."""
    state: str
    """As JSON."""


class EventStore(Protocol):
    """The journal: the only durable truth."""

    at_disk: Callable[[], None]
    """Called by an `append` that has nothing left to do but to wait for the disk.

    Its user sets it.
    """

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

    @property
    def epoch(self) -> int:
        """Return the number of this writer, higher than that of every earlier one.

        0: another writer is impossible as long as this one lives.
        """

    def may_command(self) -> bool:
        """Tell whether a goal may be sent at this moment (semantics 9.4).

        It may not once another node may have taken over the journal. Only `append` and `renew`
        find that out; each answer is valid for a short time.
        """

    def absent_at(self, seq: int) -> ClockReading | None:
        """Return a moment at which an event was not yet in the journal; None: not known.

        This machine has looked itself: the moment is by its own clocks (semantics 9.4).
        """


class Journal(EventStore, Protocol):
    """A journal that outlives its process, and is kept short for the next start."""

    @property
    def is_shared(self) -> bool:
        """Tell whether another machine can go on with it: then a node that cannot write ends."""

    @property
    def alone_from_s(self) -> float:
        """Return the time from which no earlier writer sends a goal, by the monotonic clock."""

    def renew(self) -> None:
        """Check that this is still the writer, and let it command for some more seconds.

        :raises JournalFailed: another node has taken over, or that is not known
        """

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


# The journal of another node, as a standby sees it.


class Seen(NamedTuple):
    """The end of the journal of a leader."""

    history: str
    """Empty: there is no journal yet."""
    seq: int
    """The last event in it."""
    epoch: int
    leader: str
    """The last node that wrote it: host and process."""
    is_led: bool
    """A node has it now."""


class StandbyJournal(Protocol):
    """A journal that another node writes, and that this one may go on with. One thread uses it."""

    def look(self) -> Seen:
        """Look at its end, and note when that was (`EventStore.absent_at`).

        :raises JournalAway: it cannot be reached at this moment
        :raises JournalUnusable: no node can go on with it
        """

    def take(self) -> Journal | None:
        """Become its writer, if it has none; None: it has one.

        :raises JournalAway: it cannot be reached at this moment
        :raises JournalUnusable: no node can go on with it
        """

    def close(self) -> None:
        """Stop looking."""
