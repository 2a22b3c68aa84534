"""Books on time: made from so many events, and always before retention removes these.

They are made elsewhere (`ports.Bookkeeping`), and stored by the writer; the tick thread only hands
them over. If they cannot be made, retention waits, but not for ever: the disk must not fill.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from functools import partial
from typing import TypeVar

from bt_orchestrator.base.replies import Reply, begin
from bt_orchestrator.model.state import CellState
from bt_orchestrator.ports import Bookkeeping, Journal, Writer, Writing

log = logging.getLogger(__name__)

_T = TypeVar('_T')

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
