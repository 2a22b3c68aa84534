"""Events that were heard over the door, read like a journal.

The ring has those since the page began. The ones before are fetched when somebody looks for the
first time, so that a page that nobody asks for the past costs the node nothing.
"""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Sequence

from bt_orchestrator.base.errors import JournalUnusable, NodeUnreachable
from bt_orchestrator.extensions.page.web.board import MOST_EVENTS_KEPT, Board
from bt_orchestrator.model.keeping.books import WithoutBooks
from bt_orchestrator.model.keeping.records import (
    Damage,
    Extent,
    JobPlace,
    Record,
    RecordPage,
    Summaries,
    Wanted,
)
from bt_orchestrator.ports.doors.doors import Doors
from bt_orchestrator.ports.doors.following_door import Happened, Lost

MOST = 1000
"""Most records of a page."""

PATIENCE_S = 5.0
"""Longest wait for events of before; what has come by then is shown."""

Entry = Happened | Lost


class HeardRecords(WithoutBooks):
    """Events of one moment. Implements `ports.Records`."""

    def __init__(self, history: str, before: int, entries: Sequence[Entry]) -> None:
        """Keep events.

        :param before: the number before the first of them
        :param entries: without a hole, in order
        """
        self._history = history
        self._before = before
        self._entries = entries

    def extent(self) -> Extent:
        """Return the range of events in it."""
        last = self._entries[-1].last if self._entries else self._before
        return Extent(self._history, self._before + 1, last)

    def page(self, wanted: Wanted, most: int = MOST) -> RecordPage:
        """Return the next wanted records."""
        history, first, last = self.extent()
        end = last + 1 if wanted.before_seq is None else wanted.before_seq
        entries = reversed(self._entries) if wanted.newest_first else self._entries
        records: list[Record] = []
        damage: list[Damage] = []
        for entry in entries:
            if entry.last <= wanted.after_seq or entry.first >= end:
                continue
            if isinstance(entry, Lost):
                damage.append(_lost(entry))
            elif _takes(wanted, entry):
                records.append(Record(entry.first, entry.text))
                if len(records) == most:
                    rest = wanted.past(entry.first)
                    return RecordPage(history, first, records, damage, rest, is_last=False)
        done = max(wanted.after_seq + 1, first) if wanted.newest_first else min(end - 1, last)
        rest = wanted.past(max(done, wanted.after_seq))
        return RecordPage(history, first, records, damage, rest, is_last=True)

    def summaries(
        self,
        after: JobPlace | None = None,  # noqa: ARG002 - the port's
        most: int = MOST,  # noqa: ARG002
        *,
        newest_first: bool = False,  # noqa: ARG002
    ) -> Summaries:
        """Return nothing: the door tells no summaries."""
        return Summaries((), (), None)

    def state_before(self, seq: int) -> None:
        """Return no state: the door tells only that of now."""

    def close(self) -> None:
        """Do nothing: it is a copy."""


def _takes(wanted: Wanted, entry: Happened) -> bool:
    event = entry.event
    return wanted.takes(event.event, getattr(event, 'job', None), event.time)


def _lost(entry: Lost) -> Damage:
    number = entry.last - entry.first + 1
    which = f'events {entry.first} to {entry.last}' if number > 1 else f'event {entry.first}'
    return Damage(f'the node has lost {which} for good', number)


class Heard:
    """Collects what the door tells. All calls come from the loop's thread."""

    def __init__(self, board: Board, doors: Doors) -> None:
        self._board = board
        self._doors = doors
        self._earlier: list[Entry] = []
        self._before = 0
        """The number before the first of those."""
        self._history = ''
        """Of those."""
        self._filling: asyncio.Task[bool] | None = None
        """Whether all of them came; None: not looked for yet."""

    async def records(self) -> HeardRecords:
        """Return what is known; the first call fetches what was before the page.

        :raises JournalUnusable: nothing was heard of the node yet
        """
        board = self._board
        if not board.history:
            raise JournalUnusable(f'nothing was heard of {self._doors.name} yet')
        if self._history != board.history or self._is_to_do:
            self._history, self._earlier = board.history, []
            self._filling = asyncio.ensure_future(self._fill(board.history, board.ring.before))
        if self._filling is not None and not self._filling.done():
            with contextlib.suppress(TimeoutError, asyncio.TimeoutError):
                await asyncio.wait_for(asyncio.shield(self._filling), PATIENCE_S)
        ring = board.ring
        entries: list[Entry] = ring.entries()
        before = ring.before
        if self._history == board.history and self._earlier and self._earlier[-1].last == before:
            entries, before = [*self._earlier, *entries], self._before
        if len(entries) > MOST_EVENTS_KEPT:
            before = entries[-MOST_EVENTS_KEPT - 1].last
            entries = entries[-MOST_EVENTS_KEPT:]
        return HeardRecords(board.history, before, entries)

    @property
    def _is_to_do(self) -> bool:
        """Tell whether the node did not tell everything when it was asked."""
        filling = self._filling
        return filling is not None and filling.done() and not filling.result()

    async def _fill(self, history: str, last: int) -> bool:
        """Fetch the last events up to one, oldest first; tell whether all of them came."""
        entries: list[Entry] = []
        after = before = max(0, last - MOST_EVENTS_KEPT)
        with contextlib.suppress(NodeUnreachable):
            while after < last:
                page = await self._doors.events_after(after)
                if page.history != history or not page.events:
                    break
                if not entries:  # earlier ones are removed
                    after = before = max(after, page.events[0].seq - 1)
                if page.events[0].seq > after + 1:
                    entries.append(Lost(after + 1, page.events[0].seq - 1))
                entries += [Happened(event) for event in page.events if event.seq <= last]
                after = page.events[-1].seq
        if after < last or self._history != history:
            return False
        self._earlier, self._before = entries, before
        return True
