"""The outcomes of commands, by their tickets: no command is done twice, and no answer is lost."""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Protocol

from bt_orchestrator.base.errors import NodeUnreachable, OrchestratorError
from bt_orchestrator.model.by import named, ticket_in
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.events import Event, OperatorDecided, OperatorRefused
from bt_orchestrator.model.requests import Asked, Why
from bt_orchestrator.model.words import sentence
from bt_orchestrator.ports import EventPage

LOOK_BACK = 2_000
"""How many of the last events are searched for a ticket."""

SETTLED_S = 10.0
"""A command without an answer that the journal does not have after so long, never arrived."""

AT_ONCE = 8
"""Commands that are under way at a time; the others wait. The door asks one after the other, so an
emergency, which does not wait here, would come behind all that were sent; and each is looked up in
what has happened since it was sent, which the others are a part of."""

MOST_KEPT = 1_000
"""Commands that are remembered here; of older ones only the journal knows."""

_SILENT = sentence('node_silent')

Recorded = OperatorDecided | OperatorRefused


class Doors(Protocol):
    """The operations at the doors to the node; all raise NodeUnreachable."""

    @property
    def is_silent(self) -> bool:
        """Tell whether the node is away."""

    async def ask(self, asked: Asked) -> Answer:
        """Make a request."""

    async def events_after(self, seq: int, most: int = 0) -> EventPage:
        """Return events from the journal."""


class Unknown(OrchestratorError):
    """The node did not answer: whether the command was carried out is not known."""


class NotSent(OrchestratorError):
    """The node is silent: nothing was sent."""


class TicketTaken(OrchestratorError):
    """Another command has this ticket."""


@dataclass(frozen=True)
class Outcome:
    """The outcome of a command."""

    accepted: bool
    message: str
    findings: tuple[str, ...] = ()
    recorded: tuple[Recorded, ...] = ()
    """As the journal has it; empty: not found there, or counted with other refusals."""

    def note(self, program: str) -> str:
        """Say that the node does not count the role that a program asserts; empty: it does.

        :param program: its name
        """
        recorded = self.recorded[0] if self.recorded else None
        if recorded is None or not recorded.claims:
            return ''
        return (
            f'the node counts the role {recorded.role}, and records {recorded.claims} as a claim: '
            f'it does not trust this {program} so far (a key for it, or trust_local_doors)'
        )


@dataclass(frozen=True)
class Search:
    """A search of the journal, for one ticket."""

    outcome: Outcome | None
    """None: it is not there."""
    first: int = 0
    last: int = 0
    """The events that were looked through."""
    is_silent: bool = False
    """The node does not answer: nothing was looked through."""


@dataclass
class _Kept:
    """A command that this program was asked for."""

    asked: Asked
    before: int
    """The last event that was known then."""
    task: asyncio.Task[Outcome] = field(init=False)
    lost_at: float | None = None
    """When its answer was lost, on the clock; None: it was not."""
    is_again: bool = False
    """It was sent before: its record may be older than this."""

    def is_of(self, asked: Asked) -> bool:
        mine = self.asked
        same = (mine.request.name, dict(mine.arguments)) == (
            asked.request.name,
            dict(asked.arguments),
        )
        return same and mine.sender.who == asked.sender.who


class Tickets:
    """All calls come from the loop's thread."""

    def __init__(
        self,
        doors: Doors,
        newest: Callable[[], int],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Know nothing yet.

        :param newest: the last event that is known of
        :param clock: steady, seconds
        """
        self._clock = clock
        self.doors = doors
        self._newest = newest
        self._kept: dict[str, _Kept] = {}
        self._room = asyncio.Semaphore(AT_ONCE)
        self._earlier: Mapping[str, list[Recorded]] | None = None
        """On record before this program first asked something; None: not looked yet."""

    async def carry_out(self, ticket: str, asked: Asked) -> Outcome:
        """Carry out a command once; again the same answer for the same ticket.

        :raises NotSent: the node is silent
        :raises Unknown: the node did not answer
        :raises TicketTaken: another command has the ticket
        """
        kept = self._kept.get(ticket)
        if kept is None:
            await self._look_earlier(asked)
            kept = self._kept.get(ticket)  # somebody may have been quicker
        if kept is None:
            earlier = (self._earlier or {}).get(ticket)
            if earlier:
                return _of_record(earlier, asked)
            kept = self._begin(ticket, asked, self._newest())
        elif not kept.is_of(asked):
            raise TicketTaken(f'the ticket {ticket} is of another command; make a new one')
        elif kept.lost_at is not None:
            return await self._again(ticket, kept)
        return await asyncio.shield(kept.task)

    async def find(self, ticket: str) -> Search:
        """Return what became of a command, from the journal if this program does not know."""
        kept = self._kept.get(ticket)
        if kept is not None:
            try:
                return Search(await asyncio.shield(kept.task))
            except (Unknown, NotSent):
                pass
        try:
            return await self._search(ticket, None if kept is None else kept.before)
        except NodeUnreachable:
            return Search(None, is_silent=True)

    async def _again(self, ticket: str, kept: _Kept) -> Outcome:
        """Answer for a command whose answer was lost; send it anew if it surely never came."""
        lost_for_s = self._clock() - (kept.lost_at or 0.0)
        try:
            search = await self._search(ticket, kept.before)
        except NodeUnreachable as error:
            raise Unknown(f'{error}; whether it was carried out is not known') from error
        if search.outcome is not None:
            return search.outcome
        if lost_for_s < SETTLED_S:
            raise Unknown(
                'the journal does not have it yet; whether it was carried out is not known; ask '
                f'again in {math.ceil(SETTLED_S - lost_for_s)} s'
            )
        if self._kept.get(ticket) is kept:  # else somebody was quicker
            self._begin(ticket, kept.asked, kept.before, is_again=True)
        return await asyncio.shield(self._kept[ticket].task)

    def _begin(self, ticket: str, asked: Asked, before: int, *, is_again: bool = False) -> _Kept:
        kept = self._kept[ticket] = _Kept(asked, before, is_again=is_again)
        # The command goes on when its sender has gone.
        kept.task = asyncio.create_task(self._carried_out(ticket, kept))
        kept.task.add_done_callback(_heard)
        old = [key for key, entry in self._kept.items() if entry.task.done()]
        for key in old[: max(0, len(self._kept) - MOST_KEPT)]:
            del self._kept[key]
        return kept

    async def _carried_out(self, ticket: str, kept: _Kept) -> Outcome:
        if kept.asked.request.why is Why.AFTERWARDS:
            return await self._sent(ticket, kept)
        async with self._room:
            if not kept.is_again:
                self._refuse_if_silent(ticket, kept)
                kept.before = self._newest()
            return await self._sent(ticket, kept)

    def _refuse_if_silent(self, ticket: str, kept: _Kept) -> None:
        """Send nothing to a node that went away while the command waited for room."""
        if self.doors.is_silent:
            if self._kept.get(ticket) is kept:
                del self._kept[ticket]
            raise NotSent(_SILENT)

    async def _sent(self, ticket: str, kept: _Kept) -> Outcome:
        try:
            answer = await self.doors.ask(kept.asked)
        except NodeUnreachable as error:
            kept.lost_at = self._clock()
            raise Unknown(f'{error}; whether it was carried out is not known') from error
        findings = tuple(finding for order in answer.orders for finding in order.findings)
        try:
            events = await self._events_of(ticket, kept.before)
        except NodeUnreachable:
            events = []
        return Outcome(answer.accepted, answer.message, findings, tuple(events))

    # --- the journal ------------------------------------------------------------------------

    async def _look_earlier(self, asked: Asked) -> None:
        """Look once what is on record from before this program was started.

        A program that was killed may have sent the very command that comes again now. An emergency
        does not wait for that: to abort, pause or stop twice is to do it once.

        :raises NotSent: the node is silent
        """
        if asked.request.why is Why.AFTERWARDS:
            return
        if self.doors.is_silent:
            raise NotSent(_SILENT)
        if self._earlier is not None:
            return
        by_ticket: dict[str, list[Recorded]] = {}
        try:
            events, _, _ = await self._events(None)
        except NodeUnreachable as error:
            raise NotSent(f'{error}; nothing was sent') from error
        for event in events:
            if isinstance(event, Recorded) and (ticket := ticket_in(event.origin)):
                by_ticket.setdefault(ticket, []).append(event)
        self._earlier = by_ticket

    async def _search(self, ticket: str, after: int | None) -> Search:
        events, first, last = await self._events(after)
        own_events = _with(ticket, events)
        return Search(_of_record(own_events) if own_events else None, first, last)

    async def _events_of(self, ticket: str, after: int) -> list[Recorded]:
        events, _, _ = await self._events(after)
        return _with(ticket, events)

    async def _events(self, after: int | None) -> tuple[list[Event], int, int]:
        """Return the events after one, or the last ones, and which they are.

        :raises NodeUnreachable: it does not answer
        """
        page = await self.doors.events_after(self._newest(), 1)
        last = page.last_seq
        seq = max(last - LOOK_BACK, page.first_seq - 1, -1 if after is None else min(after, last))
        first, events = seq + 1, list[Event]()
        while seq < last:
            page = await self.doors.events_after(seq)
            if not page.events:
                break
            events += page.events
            seq = page.events[-1].seq
        return events, first, seq


def _with(ticket: str, events: Iterable[Event]) -> list[Recorded]:
    return [
        event
        for event in events
        if isinstance(event, Recorded) and ticket_in(event.origin) == ticket
    ]


def _of_record(records: Iterable[Recorded], asked: Asked | None = None) -> Outcome:
    """Return the outcome as the journal has it.

    :raises TicketTaken: it is of another command than is asked now
    """
    events = tuple(records)
    for event in events:
        word = event.answer if isinstance(event, OperatorDecided) else event.command
        if asked is not None and (event.who, word) != (asked.sender.who, asked.request.word):
            raise TicketTaken('this ticket is of another command; make a new one')
    refusals = [event.message for event in events if isinstance(event, OperatorRefused)]
    messages = refusals or [
        _decided(event) for event in events if isinstance(event, OperatorDecided)
    ]
    return Outcome(not refusals, '; '.join(dict.fromkeys(messages)), recorded=events)


def _decided(event: OperatorDecided) -> str:
    about = (event.hold and f'hold {event.hold}') or event.item or event.job or ''
    return f'{named(event.who, event.known)} decided {event.answer}{about and f": {about}"}'


def _heard(task: asyncio.Task[Outcome]) -> None:
    """Take note of an error without a reader."""
    if not task.cancelled():
        task.exception()
