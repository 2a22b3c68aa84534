"""Many commands at once: each is looked up in little, and an emergency waits for few of them."""

from __future__ import annotations

import asyncio

from fakes.operator import engineer

from bt_orchestrator.model.by import origin_with
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.events import Event, OperatorDecided
from bt_orchestrator.model.requests import Asked, ask
from bt_orchestrator.ports import EventPage
from bt_orchestrator.ports.doors.tickets import AT_ONCE, NotSent, Outcome, Tickets

MANY = 200


class SerialDoors:
    """A node that is asked one command after the other, and reads between them."""

    def __init__(self) -> None:
        self.is_silent = False
        self.events: list[Event] = []
        self.told = 0
        """Events in all answers."""
        self._door = asyncio.Lock()

    async def ask(self, asked: Asked) -> Answer:
        """As `Doors`."""
        async with self._door:
            await asyncio.sleep(0)
            by = asked.sender
            info = {'who': by.who, 'origin': by.origin, 'role': by.role.value, 'reason': by.reason}
            seq, word = len(self.events) + 1, asked.request.word
            self.events.append(OperatorDecided(seq=seq, time=0.0, answer=word, **info))
            return Answer(accepted=True, message=word)

    async def events_after(self, seq: int, most: int = 0) -> EventPage:
        """As `Doors`."""
        await asyncio.sleep(0)
        events = self.events[seq : seq + most] if most else self.events[seq:]
        self.told += len(events)
        return EventPage('h', events, 1, len(self.events))


def asked(name: str, ticket: str, **arguments: object) -> Asked:
    return ask(name, engineer('mes', origin_with('opcua', ticket)), **arguments)


def ticket(number: int) -> str:
    return f'{number:016x}'


async def begun(doors: SerialDoors) -> tuple[Tickets, list[asyncio.Task[Outcome]]]:
    """Begin a burst of commands, until the first one has reached the node."""
    tickets = Tickets(doors, lambda: len(doors.events))
    waiting = [
        asyncio.ensure_future(
            tickets.carry_out(ticket(call), asked('job.hold', ticket(call), job=f'J{call}'))
        )
        for call in range(MANY)
    ]
    while not (doors.events or any(call.done() for call in waiting)):
        await asyncio.sleep(0)
    return tickets, waiting


def test_burst_is_read_once_and_emergency_overtakes_it() -> None:
    doors = SerialDoors()

    async def burst() -> list[Outcome]:
        tickets, waiting = await begun(doors)
        await tickets.carry_out(ticket(MANY), asked('cell.abort', ticket(MANY)))
        return await asyncio.gather(*waiting)

    outcomes = asyncio.run(burst())
    assert all(len(outcome.recorded) == 1 for outcome in outcomes), 'each finds its own record'
    words = [event.answer for event in doors.events if isinstance(event, OperatorDecided)]
    assert words.index('abort') <= AT_ONCE + 1
    assert doors.told <= MANY * (2 * AT_ONCE + 2)


def test_queued_command_is_not_sent_to_lost_node() -> None:
    doors = SerialDoors()

    async def burst() -> list[object]:
        tickets, waiting = await begun(doors)
        doors.is_silent = True
        results = await asyncio.gather(*waiting, return_exceptions=True)
        doors.is_silent = False
        again = asked('job.hold', ticket(MANY - 1), job=f'J{MANY - 1}')
        assert (await tickets.carry_out(ticket(MANY - 1), again)).accepted, 'it may come again'
        return list(results)

    results = asyncio.run(burst())
    assert sum(isinstance(result, NotSent) for result in results) >= MANY - 2 * AT_ONCE
    assert len(doors.events) == 1 + sum(isinstance(result, Outcome) for result in results)
