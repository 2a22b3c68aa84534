"""Commits of events to the disk, one settle at a time, and work without them (semantics 9.1)."""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from functools import partial

from bt_orchestrator.base.errors import JournalFailed
from bt_orchestrator.base.replies import Reply
from bt_orchestrator.model import effects
from bt_orchestrator.model import events as e
from bt_orchestrator.model.commands import Answer, Command, cancels_all
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.goal import NOT_HEARD
from bt_orchestrator.model.requests import Asked
from bt_orchestrator.model.words import sentence
from bt_orchestrator.ports import ActionGateway, Clock, EventStore, Goal, Timer, Writer, Writing

log = logging.getLogger(__name__)

AT_ONCE_S = 0.02
"""How long a settle waits for its commit; nearly every commit ends within it."""

SLICE_S = 0.02
"""Longest time to continue waiting commands in one settle, before other work."""

PATIENCE_S = 15.0
"""Default time after which a commit counts as failed."""


class Commits:
    """The commit in progress, if any.

    The first one has no time limit: no client is served before it has ended.
    """

    def __init__(
        self,
        store: EventStore,
        writer: Writer,
        clock: Clock,
        wake: Callable[[], None],
        patience_s: float,
        meanwhile: Callable[[Sequence[Event]], None],
    ) -> None:
        """Begin without any.

        :param meanwhile: called with the events of a commit while it is at the disk
        """
        self._store = store
        self._writer = writer
        store.at_disk = writer.reaches_disk
        self._clock = clock
        self._wake = wake
        self._patience_s = patience_s
        self._meanwhile = meanwhile
        self._at_once_s = patience_s
        self._writing: Writing[None] | None = None
        self._began = 0.0
        self._overdue: Timer | None = None
        self.events: Sequence[Event] = ()
        """The events being written."""
        self._ended: Reply[None] = Reply()
        self._turns: deque[Reply[None]] = deque()
        """Turns of commands that wait for a commit to end, oldest first."""
        self._is_handing_out = False

    @property
    def is_pending(self) -> bool:
        """Tell whether a commit is in progress."""
        return self._writing is not None

    @property
    def is_owed(self) -> bool:
        """Tell whether commands still wait for their turn, though no commit is in progress."""
        return bool(self._turns) and not self.is_pending and not self._is_handing_out

    @property
    def waited_s(self) -> float:
        """Seconds since the commit began; 0: none is in progress."""
        return self._clock.steady() - self._began if self.is_pending else 0.0

    @property
    def in_words(self) -> str:
        """The commit that is waited for; empty: none."""
        if not self.is_pending:
            return ''
        return (
            f'the disk has not taken the last {_counted(self.events)} yet: nothing is sent, and '
            'commands wait, until it has'
        )

    async def turn(self) -> None:
        """Return when a command may be carried out: in order, when no commit is in progress."""
        if self.is_pending or self.is_owed:
            self._turns.append(turn := Reply[None]())
            await turn

    async def kept(self) -> None:
        """Return when the commit has ended, successfully or not, and its goals are sent."""
        if self.is_pending:
            await self._ended

    def begin(self, events: Sequence[Event]) -> None:
        """Begin to write events."""
        assert not self.is_pending
        self.events, self._ended = events, Reply()
        self._began = self._clock.steady()
        self._writing = self._writer.begin(partial(self._store.append, events))

    def has_ended(self) -> bool:
        """Tell whether the commit has ended, or takes too long.

        The first call waits for `AT_ONCE_S`; if it returns False, a wake follows.
        """
        assert self._writing is not None
        is_first_look = self._overdue is None and not self._is_handing_out
        within_s = 0.0
        if is_first_look and self._writing.is_at_disk(self._at_once_s):
            self._meanwhile(self.events)
            within_s = max(0.0, self._at_once_s - self.waited_s)
        if self._writing.has_ended(within_s):
            return True
        if self.waited_s >= self._patience_s:
            return True
        if self._overdue is None:
            until = self._began + self._patience_s
            self._overdue = self._clock.call_at(until, self._wake)
        return False

    def end(self) -> None:
        """Conclude the commit that has ended; its events are durable.

        :raises JournalFailed: they are not; or that is unknown, as it took too long
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
        """Continue what waits: for the commit that has ended, then for a turn.

        This waits for no commit, so that other work is done in between. Thousands may have queued
        up while the disk was slow, and an answer to a client that has gone takes 0.1 s: after
        `SLICE_S` the rest continues in the next settle.
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


# The work that goes on when the journal cannot be written: cancelling goals, off the record.


class Breakdown:
    """The engine's remaining functions without a journal (semantics 9.1).

    It sends and records nothing. `abort` and the end of the node cancel every goal whose end is
    not known; every other command is refused.
    """

    def __init__(
        self, failure: str, goals: Mapping[str, tuple[e.TaskKey, Goal]], gateway: ActionGateway
    ) -> None:
        """Take over the goals of an engine.

        :param failure: why the journal cannot be written
        :param goals: by their UUID
        """
        self._failure = failure
        self._goals = dict(goals)
        self._gateway = gateway
        self._asked: set[str] = set()
        self._is_unsafe = False
        self.look()

    @property
    def message(self) -> str:
        """The error, what happens to the goals, and what to do."""
        if not self._asked:
            return sentence('broken', what=self._failure)
        left = len(self._asked & self._open().keys())
        return sentence('broken_asked', what=self._failure, count=len(self._asked), left=left)

    @property
    def in_flight(self) -> list[str]:
        """The goals that have not ended, in words."""
        return [f'{key} (goal {uuid})' for uuid, (key, _) in self._open().items()]

    def answer(self, command: Command) -> Answer:
        """Cancel every goal, or refuse."""
        if not cancels_all(command):
            return Answer(accepted=False, message=self.message)
        done = self._cancel_all()
        what = f'Abort by {command.by}' if isinstance(command, Asked) else 'Shutdown'
        log.error('%s, off the record: %s', what, done)
        message = sentence('cancelled_unrecorded', words=done, what=self._failure)
        return Answer(accepted=True, message=message)

    def look(self) -> None:
        """Note which goals have ended; nothing else drains the gateway any more."""
        self._gateway.drain()
        self._goals = self._open()
        was_unsafe, self._is_unsafe = self._is_unsafe, self._gateway.unsafe not in ('', NOT_HEARD)
        if self._is_unsafe and not was_unsafe and self._goals:
            log.error('%s: %s, off the record', self._gateway.unsafe, self._cancel_all())

    def _cancel_all(self) -> str:
        goals = self._open()
        for _, goal in goals.values():
            goal.cancel()
        self._asked.update(goals)
        return effects.cancelled_words(len(goals))

    def _open(self) -> dict[str, tuple[e.TaskKey, Goal]]:
        return {uuid: flight for uuid, flight in self._goals.items() if flight[1].end is None}
