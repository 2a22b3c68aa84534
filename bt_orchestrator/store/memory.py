"""A journal in memory: for virtual runs, and for real ones that need not survive."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from uuid import uuid4

from bt_orchestrator.model.codec import to_text
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.keeping.books import WithoutBooks
from bt_orchestrator.model.keeping.records import (
    Extent,
    JobPlace,
    Record,
    RecordPage,
    Summaries,
    Wanted,
)
from bt_orchestrator.ports import Snapshot
from bt_orchestrator.store.sequence import refuse_gap

MOST = 1000
"""Most records of a page."""


class MemoryStore:
    """Keeps events in a list. Implements `ports.EventStore`."""

    at_disk: Callable[[], None]
    epoch = 0

    def __init__(self, history: str | None = None) -> None:
        """Begin a journal.

        :param history: a fixed id for runs that must not be random, such as virtual runs
        """
        self._history = uuid4().hex if history is None else history
        self._events: list[Event] = []

    @property
    def history(self) -> str:
        """Return the unique id of the journal."""
        return self._history

    @property
    def is_restored(self) -> bool:
        """Return False: there are no copies of it."""
        return False

    def missing(self, after: int) -> str:  # noqa: ARG002 - the port's
        """Return nothing: a journal in memory is never damaged."""
        return ''

    def go_on_after(self, seq: int) -> None:
        """Do nothing: nothing is ever missing."""

    def append(self, events: Sequence[Event]) -> None:
        """Keep the events.

        :raises JournalFailed: they do not follow the last event; none of them is kept
        """
        refuse_gap(events, len(self._events))
        self._events.extend(events)

    def read(self, after: int = 0, most: int = -1) -> Sequence[Event]:
        """Return the events with a seq greater than `after`; seq counts from 1 without gaps."""
        return self._events[after:] if most < 0 else self._events[after : after + most]

    def first_seq(self) -> int:
        """Return 1: nothing is ever removed."""
        return 1

    def snapshots(self) -> Sequence[Snapshot]:
        """Return no state: a journal in memory is never started from."""
        return ()

    def used_ids(self, digest: str) -> None:
        """Return nothing: only states that are kept name such parts."""

    def beginning(self) -> None:
        """Return no state: replay begins with the first event of all."""

    def may_command(self) -> bool:
        """Return True: no other process has this journal."""
        return True

    def absent_at(self, seq: int) -> None:
        """Return no moment: there is no other node whose goals are asked for."""


class MemoryRecords(WithoutBooks):
    """Reads a journal in memory. Implements `ports.Records`."""

    def __init__(self, store: MemoryStore) -> None:
        self._store = store

    def extent(self) -> Extent:
        """Return the range of events in it."""
        return Extent(self._store.history, self._store.first_seq(), len(self._store.read()))

    def page(self, wanted: Wanted, most: int = MOST) -> RecordPage:
        """Return the next wanted records."""
        history, first, last = self.extent()
        before = last + 1 if wanted.before_seq is None else wanted.before_seq
        seqs = range(wanted.after_seq + 1, min(before, last + 1))
        records: list[Record] = []
        for seq in reversed(seqs) if wanted.newest_first else seqs:
            (event,) = self._store.read(seq - 1, 1)
            if wanted.takes(event.event, getattr(event, 'job', None), event.time):
                records.append(Record(seq, to_text(event)))
                if len(records) == most:
                    return RecordPage(history, first, records, (), wanted.past(seq), is_last=False)
        end = seqs.start if wanted.newest_first else seqs.stop - 1
        return RecordPage(history, first, records, (), wanted.past(end), is_last=True)

    def summaries(
        self,
        after: JobPlace | None = None,  # noqa: ARG002 - the port's
        most: int = MOST,  # noqa: ARG002
        *,
        newest_first: bool = False,  # noqa: ARG002
    ) -> Summaries:
        """Return nothing: no event is ever removed, so no summary is needed."""
        return Summaries((), (), None)

    def state_before(self, seq: int) -> None:
        """Return no state: every event is there."""

    def close(self) -> None:
        """Do nothing: the journal ends with its process."""
