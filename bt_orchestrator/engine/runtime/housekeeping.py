"""Keeping the journal short for the next start: snapshots and retention.

None of it delays a goal: it is done between settles, preferably when nothing happens, in small
pieces. Disk writes are left to the writer, and the work continues in a later turn. If it fails the
cell goes on; only the next start takes longer.

The cost of a snapshot grows with the state, and searching the summaries of many jobs takes long.
So ended jobs are handled in batches: a line that ends one a second must not pay for each.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from functools import partial
from typing import TypeVar

from bt_orchestrator.base.replies import Reply, begin
from bt_orchestrator.engine.runtime.recovery import stamp
from bt_orchestrator.engine.runtime.writers import WritesAtOnce
from bt_orchestrator.model.jobs.job_record import record_of
from bt_orchestrator.model.judging.used_ids import SealedIds
from bt_orchestrator.model.keeping.state_text import StateText
from bt_orchestrator.model.limits import ENDED_KEPT
from bt_orchestrator.model.state import CellState
from bt_orchestrator.ports import Bookkeeping, Journal, Snapshot, Writer, Writing

log = logging.getLogger(__name__)

_T = TypeVar('_T')

SNAPSHOT_EVERY = 1000
"""Events after which the next quiet moment is used for a snapshot."""

SNAPSHOT_AT_LATEST = 5000
"""Events after which a snapshot is made on a line that is never quiet."""

ENDED_TOGETHER = ENDED_KEPT // 2
"""Ended jobs after which the next quiet moment is used to store them and remove old events."""

ENDED_AT_LATEST = ENDED_KEPT - 10
"""The same on a line that is never quiet: the state has this list no longer."""

AT_REST = 20
"""Consecutive quiet turns after which everything is stored, whatever it costs."""

KEEP_JOBS = 1000
"""Default number of ended jobs that keep their events."""

KEEP_ALL = -1

FAREWELL_S = 10.0
"""How long the end of the node waits for its last snapshot."""


class Housekeeping:
    """Makes snapshots and removes old events. Called from the tick thread."""

    def __init__(
        self,
        state: CellState,
        journal: Journal,
        keep_jobs: int = KEEP_JOBS,
        writer: Writer | None = None,
        bookkeeping: Bookkeeping | None = None,
    ) -> None:
        """Prepare for a journal.

        :param keep_jobs: how many ended jobs keep their events, at least; KEEP_ALL: all
        :param writer: waits for the disk; None: the caller
        :param bookkeeping: makes the books of the account; None: there are none
        """
        self._state = state
        self._journal = journal
        self._keep_jobs = keep_jobs
        self._writer = writer or WritesAtOnce()
        self._books = (
            None if bookkeeping is None else BookWork(state, journal, bookkeeping, self._writer)
        )
        self._stamp = stamp(state.cell)
        self._saved_seq = max(
            (snapshot.seq for snapshot in journal.snapshots() if snapshot.stamp == self._stamp),
            default=0,
        )
        self._noted: set[str] = set()
        self._not_looked_after = 0
        """Jobs stored since the last check for events to remove."""
        self._remove_before = 0
        self._removed_before = 0
        self._failed_seq = 0
        """Last event at the last failure; there is no new attempt before the next event."""
        self._quiet_turns = 0
        self._next_turn: Reply[None] | None = None
        """The cause for which the work in progress waits; None: there is no work in progress."""

    def turn(self, *, quiet: bool) -> None:
        """Do one small piece of the due work; the state is durable.

        :param quiet: nothing happens at this moment
        """
        self._quiet_turns = self._quiet_turns + 1 if quiet else 0
        if self._books is not None:
            self._books.turn(quiet=quiet)
        if self._next_turn is not None:
            turn, self._next_turn = self._next_turn, None
            turn.give(None)
        elif self._state.seq != self._failed_seq and (quiet or self._is_overdue):
            begin(self._piece())

    @property
    def wants_turns(self) -> bool:
        """Tell whether turns that come soon after each other get on with something."""
        if self._next_turn is not None or self._remove_before > self._removed_before:
            return True
        if self._books is not None and self._books.is_at_work:
            return True
        return 0 < self._quiet_turns < AT_REST and self._behind > 0

    def finish(self) -> None:
        """Store a snapshot for the next start, if the disk allows it."""
        try:
            if self._state.seq > self._saved_seq:
                text = StateText(self._state)
                while not text.go_on():
                    pass
                for part in self._used_ids():
                    self._writer.begin(partial(self._journal.keep_used, part))
                saving = self._writer.begin(self._saving(text))
                if saving.has_ended(FAREWELL_S):
                    saving.result()
        except Exception as error:  # noqa: BLE001 - the node ends all the same
            log.warning('%s: the next start replays more events', error)

    @property
    def _behind(self) -> int:
        """Events since the last snapshot, or the last failure."""
        return self._state.seq - max(self._saved_seq, self._failed_seq)

    @property
    def _ended(self) -> int:
        """Ended jobs that are not stored yet."""
        return len(self._state.ended.keys() - self._noted)

    @property
    def _is_overdue(self) -> bool:
        """Tell whether a snapshot is due though something happens at this moment."""
        if self._behind >= max(SNAPSHOT_AT_LATEST, self._worth):
            return True
        return len(self._state.ended) >= ENDED_AT_LATEST and self._ended >= ENDED_AT_LATEST

    async def _piece(self) -> None:
        try:
            if self._is_overdue:
                await self._save()
            else:
                await self._at_leisure(self._behind, self._ended)
        except Exception as error:  # noqa: BLE001 - whatever it is, the cell goes on
            log.warning('%s: no snapshot, nothing removed; tried again later', error)
            self._failed_seq, self._remove_before = self._state.seq, 0

    async def _at_leisure(self, behind: int, ended: int) -> None:
        enough = 1 if self._quiet_turns >= AT_REST else ENDED_TOGETHER
        if ended + self._not_looked_after >= enough and behind >= self._worth:
            first = await self._first_needed()
            if ended or first:
                await self._save(first)
            self._not_looked_after = 0
        elif behind >= max(SNAPSHOT_EVERY, self._worth):
            await self._save()
        elif self._remove_before:
            await self._remove_some()

    @property
    def _worth(self) -> int:
        """Events that justify a snapshot: it takes as long as replaying one event per queued job.

        So the end of a job does not cause a long queue to be written.
        """
        return self._state.jobs.waiting

    async def _remove_some(self) -> None:
        wanted = self._remove_before
        before = wanted if self._books is None else self._books.removable(wanted)
        if before <= self._removed_before:
            return  # these events are not in the books yet
        there_are_more = await self._written(partial(self._journal.remove_batch, before))
        if not there_are_more:
            self._removed_before = before
            if before == wanted:
                self._remove_before = 0

    async def _save(self, first: int = 0) -> None:
        """Store a snapshot, and the summaries of jobs that ended.

        :param first: events before this one are removed afterwards; 0: none are
        """
        text = StateText(self._state, check=first > 0)
        while not text.go_on():
            await self._turn()
        for part in self._used_ids():
            await self._written(partial(self._journal.keep_used, part))
        ended = set(self._state.ended)
        await self._written(self._saving(text))
        self._not_looked_after += len(ended - self._noted)
        self._saved_seq, self._noted = text.seq, ended
        if first:
            await self._written(partial(self._journal.begin_with, self._snapshot(text)))
            self._remove_before = first

    def _used_ids(self) -> Sequence[SealedIds]:
        """Return the parts of used ids that have to be stored before a state that names them."""
        used = (self._state.order_ids, self._state.serials)
        return self._journal.lacking(part for ids in used for part in ids.parts.values())

    def _saving(self, text: StateText) -> Callable[[], None]:
        ended = [job for name, job in self._state.ended.items() if name not in self._noted]
        records = [record_of(job) for job in ended]
        return partial(self._journal.save, self._snapshot(text), records)

    def _snapshot(self, text: StateText) -> Snapshot:
        return Snapshot(text.seq, self._stamp, text.text)

    async def _first_needed(self) -> int:
        """Return the first event to keep; 0: nothing has to be removed."""
        if self._keep_jobs == KEEP_ALL:
            return 0
        live = frozenset(self._state.jobs)
        first = await self._written(partial(self._journal.first_needed, live, self._keep_jobs))
        return first if first > await self._written(self._journal.first_seq) else 0

    async def _written(self, write: Callable[[], _T]) -> _T:
        """Write by the writer, and return the result in a later turn."""
        writing = self._writer.begin(write)
        while not writing.has_ended():
            await self._turn()
        return writing.result()

    async def _turn(self) -> None:
        """Return in the next turn."""
        self._next_turn = turn = Reply[None]()
        await turn


# Books on time: made from so many events, and always before retention removes these.
#
# They are made elsewhere (`ports.Bookkeeping`), and stored by the writer; the tick thread only
# hands them over. If they cannot be made, retention waits, but not for ever: the disk must not
# fill.

BOOKS_EVERY = 20_000
"""Events after which a quiet moment is used to begin new books."""

BOOKS_AT_LATEST = 50_000
"""The same on a line that is never quiet."""

TRY_AGAIN_AFTER = 2_000
"""Events after which it is tried again, if it failed."""

WAIT_AT_MOST = 100_000
"""Events for which retention waits, from the first failure on."""


class BookWork:
    """Has books made. Called from the tick thread."""

    def __init__(
        self, state: CellState, journal: Journal, bookkeeping: Bookkeeping, writer: Writer
    ) -> None:
        self._state = state
        self._journal = journal
        self._bookkeeping = bookkeeping
        self._writer = writer
        self._reached = min(journal.booked(), state.seq)
        """Last event that is in books."""
        self._wanted = 0
        """Up to this event they are wanted, because retention waits."""
        self._is_behind = False
        """There were more events than one answer takes in."""
        self._failed: int | None = None
        """Last event at the first failure since books were made; None: there was none."""
        self._tried = 0
        """Last event at the last failure."""
        self._next_turn: Reply[None] | None = None

    @property
    def is_at_work(self) -> bool:
        """Tell whether books are being made."""
        return self._next_turn is not None

    def removable(self, before: int) -> int:
        """Return before which event retention may remove, of what it wants to remove."""
        if self._failed is not None and self._state.seq - self._failed >= WAIT_AT_MOST:
            return before
        self._wanted = max(self._wanted, before - 1)
        return min(before, self._reached + 1)

    def turn(self, *, quiet: bool) -> None:
        """Begin new books, if they are due; the state is durable.

        :param quiet: nothing happens at this moment
        """
        if self._next_turn is not None:
            turn, self._next_turn = self._next_turn, None
            turn.give(None)
        elif self._is_due(quiet=quiet):
            begin(self._make())

    def _is_due(self, *, quiet: bool) -> bool:
        if self._failed is not None and self._state.seq - self._tried < TRY_AGAIN_AFTER:
            return False
        behind = self._state.seq - self._reached
        if not quiet:
            return behind >= BOOKS_AT_LATEST
        return behind >= BOOKS_EVERY or self._is_behind or self._wanted > self._reached

    async def _make(self) -> None:
        try:
            made = await self._ended(self._bookkeeping.begin())
            write: Callable[[], None] = partial(self._journal.keep_books, made)
            await self._ended(self._writer.begin(write))
        except Exception as error:  # noqa: BLE001 - whatever it is, the cell goes on
            self._tried = self._state.seq
            if self._failed is None:
                self._failed = self._state.seq
                log.warning(
                    'the books of the account cannot be made (%s); it is tried again, and no '
                    'event is removed meanwhile, for %d events at most',
                    error,
                    WAIT_AT_MOST,
                )
        else:
            self._failed = None
            self._reached, self._is_behind = made.reached, not made.is_last

    async def _ended(self, work: Writing[_T]) -> _T:
        """Return the result of some work in a later turn."""
        while not work.has_ended():
            self._next_turn = turn = Reply[None]()
            await turn
        return work.result()
