"""Events on their way to the disk, one settle's at a time (semantics 9.1)."""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable, Sequence
from functools import partial

from bt_orchestrator.errors import JournalFailed
from bt_orchestrator.model.events import Event
from bt_orchestrator.ports import Clock, EventStore, Timer, Writer, Writing
from bt_orchestrator.replies import Reply

log = logging.getLogger(__name__)

AT_ONCE_S = 0.02
"""So long a settle waits for its commit: nearly every one ends within it."""

SLICE_S = 0.02
"""So long commands are let go on one after the other; then others are served first."""

PATIENCE_S = 15.0
"""A commit that takes longer than this has failed, unless somebody says otherwise."""


class Commits:
    """The commit that is under way, if there is one.

    The first one may take all the time there is: nobody is served before it has ended.
    """

    def __init__(
        self,
        store: EventStore,
        writer: Writer,
        clock: Clock,
        wake: Callable[[], None],
        patience_s: float,
    ) -> None:
        self._store = store
        self._writer = writer
        self._clock = clock
        self._wake = wake
        self._patience_s = patience_s
        self._at_once_s = patience_s
        self._writing: Writing[None] | None = None
        self._began = 0.0
        self._overdue: Timer | None = None
        self.events: Sequence[Event] = ()
        """Those that are being written."""
        self._ended: Reply[None] = Reply()
        self._turns: deque[Reply[None]] = deque()
        """Of commands that wait until one has ended, oldest first."""
        self._is_handing_out = False

    @property
    def is_pending(self) -> bool:
        """Tell whether one is under way."""
        return self._writing is not None

    @property
    def is_owed(self) -> bool:
        """Tell whether commands still wait for their turn, though nothing is under way."""
        return bool(self._turns) and not self.is_pending and not self._is_handing_out

    @property
    def waited_s(self) -> float:
        """For how long it has been under way; 0: none is."""
        return self._clock.steady() - self._began if self.is_pending else 0.0

    @property
    def in_words(self) -> str:
        """What is waited for; empty: nothing is."""
        if not self.is_pending:
            return ''
        return (
            f'the disk has not taken the last {_counted(self.events)} yet: nothing is sent, and '
            'commands wait, until it has'
        )

    async def turn(self) -> None:
        """Return when a command may be carried out: each in its turn, when none is under way."""
        if self.is_pending or self.is_owed:
            self._turns.append(turn := Reply[None]())
            await turn

    async def kept(self) -> None:
        """Return when what was begun has ended, well or not, and its goals are sent."""
        if self.is_pending:
            await self._ended

    def begin(self, events: Sequence[Event]) -> None:
        """Let events be written."""
        assert not self.is_pending
        self.events, self._ended = events, Reply()
        self._began = self._clock.steady()
        self._writing = self._writer.begin(partial(self._store.append, events))

    def has_ended(self) -> bool:
        """Tell whether the one under way has ended, or takes too long.

        Waits for a moment when it is asked first; if it says no, a wake follows.
        """
        assert self._writing is not None
        is_first_look = self._overdue is None and not self._is_handing_out
        if self._writing.has_ended(self._at_once_s if is_first_look else 0.0):
            return True
        if self.waited_s >= self._patience_s:
            return True
        if self._overdue is None:
            until = self._began + self._patience_s
            self._overdue = self._clock.call_at(until, self._wake)
        return False

    def end(self) -> None:
        """Take note that the one under way has ended; its events are durable.

        :raises JournalFailed: they are not; or nobody knows, for it took too long
        """
        assert self._writing is not None
        writing, self._writing = self._writing, None
        if self._overdue is not None:
            self._overdue.cancel()
            self._overdue = None
        events, self.events = self.events, ()
        if not writing.has_ended():
            raise JournalFailed(
                f'the journal has not taken the last {_counted(events)} within '
                f'{self._patience_s:g} s, and may take them still or not'
            )
        try:
            writing.result()
        except JournalFailed:
            raise
        except Exception as error:
            raise JournalFailed(f'the journal cannot be written: {error!r}') from error
        self._at_once_s = AT_ONCE_S

    def hand_out(self) -> None:
        """Let those go on who wait: for the one that has ended, then for their turn.

        Nobody's commit is waited for here, so that others are served between them. Thousands may
        have come while the disk was slow, and an answer to a client that has gone takes 0.1 s:
        what is left after a moment goes on in the next settle.
        """
        self._is_handing_out = True
        until = self._clock.steady() + SLICE_S
        try:
            if not self._ended.is_there:
                _give(self._ended)
            while self._turns and not self.is_pending:
                if self._clock.steady() >= until:
                    self._wake()
                    return
                _give(self._turns.popleft())
        finally:
            self._is_handing_out = False


def _give(reply: Reply[None]) -> None:
    try:
        reply.give(None)
    except Exception:
        log.exception('what waited for the journal failed')


def _counted(events: Sequence[Event]) -> str:
    return f'{len(events)} events' if len(events) != 1 else 'event'
