"""The journal as its readers see it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple, Protocol

from bt_orchestrator.model.keeping.books import KeptScript, KeptState, ReasonPage, SlotPage
from bt_orchestrator.model.keeping.records import Extent, JobPlace, RecordPage, Summaries, Wanted
from bt_orchestrator.ports.journal import Snapshot


class PlantCell(NamedTuple):
    """How a cell stood when its last events came."""

    name: str
    state: str
    """PackML state; empty: not known yet."""
    state_since: float | None
    """Seconds since the epoch."""
    stop_reason: str
    """own_fault, say (semantics 7.2); empty: none."""
    last_seq: int
    last_event: float | None
    """Time of its last event."""
    behind_s: float | None
    """Seconds since the writer knew that nothing was missing; None: it never did."""
    gaps: int
    """Stretches of events that will never come."""
    page: str
    """Address of its operator page; empty: not known."""


PlantCells = Callable[[], Sequence[PlantCell]]
"""Reads the cells, in the order of their names; raises JournalUnusable."""


class Records(Protocol):
    """A journal as its readers see it, with or without a running writer.

    Reading changes nothing. Each answer is consistent and quick, so the writer never has to wait.
    Damaged or missing records are reported in the answer, never silently left out. Items are a
    fold of the records of their job (`report.reading`). One thread at a time.
    """

    def extent(self) -> Extent:
        """Return the range of events in it.

        :raises JournalUnusable: it cannot be read
        """

    def page(self, wanted: Wanted, most: int = 1000) -> RecordPage:
        """Return the next wanted records; continue with `RecordPage.rest`.

        A page that is not the last may have fewer than `most` records, or none: it also ends after
        a limit of records read.

        :raises JournalUnusable: it cannot be read
        """

    def summaries(
        self, after: JobPlace | None = None, most: int = 1000, *, newest_first: bool = False
    ) -> Summaries:
        """Return the summaries of jobs that ended, with or without events, in queue order.

        :param after: where to continue (`Summaries.rest`); None: from the first
        :raises JournalUnusable: it cannot be read
        """

    def state_before(self, seq: int) -> Snapshot | None:
        """Return a stored state from which few events lead to the state after an event.

        None: there is none; then replay begins with the first event, if that is kept.

        :raises JournalUnusable: it cannot be read
        """

    def booked(
        self, begin_us: int, end_us: int, most: int = 1000, *, newest_first: bool = False
    ) -> SlotPage:
        """Return the slots of the account that lie between two moments, or touch what does.

        In their order, which `newest_first` turns round; only oldest first it goes on with
        `SlotPage.rest_us`.

        :raises JournalUnusable: it cannot be read
        """

    def book_state(self, at_us: int, first_seq: int = 0) -> KeptState | None:
        """Return the newest sound state of the account that is not after a moment.

        :param first_seq: nor is it before this event
        :raises JournalUnusable: it cannot be read
        """

    def book_script(self, digest: str) -> KeptScript | None:
        """Return a script whose work is in the journal; None: it is missing, or damaged.

        :raises JournalUnusable: it cannot be read
        """

    def book_reasons(self, after_seq: int = 0, most: int = 1000) -> ReasonPage:
        """Return the reasons of stops that were given after an event, as far as books go.

        It goes on with `ReasonPage.rest_seq`.

        :raises JournalUnusable: it cannot be read
        """

    def close(self) -> None:
        """Close it."""
