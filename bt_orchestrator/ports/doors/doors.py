"""The questions of a program to the node, asked in a thread of their own."""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import queue
import threading
from collections.abc import Callable
from typing import Any, TypeVar

from bt_orchestrator.base.errors import NodeUnreachable
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.requests import Asked
from bt_orchestrator.model.status import CellDescription
from bt_orchestrator.ports import CellLink, EventPage, Moment, QueuePage
from bt_orchestrator.ports.doors.following_door import FollowingDoor
from bt_orchestrator.ports.doors.open_door import FAREWELL_S, Ending, OpenDoor

_T = TypeVar('_T')

SILENT_S = 3.0
"""A node that says nothing for so long is away: it says something once a second."""


class Doors:
    """The questions of a program to the node.

    Each raises NodeUnreachable if the node does not answer.

    A question that only reads is refused at once while the node is silent; a command is sent all
    the same.
    """

    def __init__(self, name: str, following: FollowingDoor, asking: AskingDoor) -> None:
        self.name = name
        """Full name of the node."""
        self._following = following
        self._asking = asking

    @property
    def silent_s(self) -> float:
        """For how long nothing was heard of the node, seconds."""
        return self._following.silent_s

    @property
    def is_silent(self) -> bool:
        """Tell whether the node is away."""
        return self.silent_s >= SILENT_S

    async def ask(self, asked: Asked) -> Answer:
        """Make a request, and return its answer, which is on record then."""
        return await self._asking.call(lambda door: door.ask(asked), AskingDoor.COMMAND)

    async def read(self, question: Callable[[CellLink], _T]) -> _T:
        """Return what a question comes to that changes nothing."""
        if self.is_silent:
            raise NodeUnreachable(
                f'{self.name} has been silent for {self.silent_s:.0f} s; is the tree node running?'
            )
        return await self._asking.call(question)

    async def description(self) -> CellDescription:
        """Return what exists in the cell."""
        return await self.read(lambda door: door.description())

    async def events_after(self, seq: int, most: int = 0) -> EventPage:
        """Return events from the journal of the cell."""
        return await self.read(lambda door: door.events_after(seq, most))

    async def queue(self, after: str = '', most: int = 0) -> QueuePage:
        """Return jobs of the queue, in order."""
        return await self.read(lambda door: door.queue(after, most))

    async def moment(self) -> Moment:
        """Return the state of now, for a virtual run that begins with it."""
        return await self.read(lambda door: door.moment())


# The door that asks the node, in a thread of its own; answers come back as awaitables.


class AskingDoor:
    """Asks the node one question after the other, commands first."""

    COMMAND, READING = 0, 1

    def __init__(self, program: str, open_door: OpenDoor, loop: asyncio.AbstractEventLoop) -> None:
        """Prepare.

        :param program: its name, for that of the thread and for messages
        """
        self._ends = f'the {program} ends'
        self._open = open_door
        self._loop = loop
        self._numbers = itertools.count()
        self._questions: queue.PriorityQueue[tuple[int, int, Any, Any]] = queue.PriorityQueue()
        self._is_ending = False
        self._is_deaf = False
        self._thread = threading.Thread(target=self._run, name=f'{program}: asking', daemon=True)

    def start(self) -> None:
        """Be ready; the door is opened with the first question, which takes a second or two."""
        self._thread.start()

    async def call(self, question: Callable[[CellLink], _T], urgency: int = READING) -> _T:
        """Return what a question to the door comes to.

        :raises NodeUnreachable: the node does not answer, or the program ends
        """
        future: asyncio.Future[_T] = self._loop.create_future()
        if self._is_ending:
            raise NodeUnreachable(self._ends)
        self._questions.put((urgency, next(self._numbers), question, future))
        return await future

    def renew(self) -> None:
        """Have the next question asked through another door; from any thread."""
        self._is_deaf = True

    def end(self) -> None:
        """Refuse what was not asked yet, and ask the thread to end."""
        self._is_ending = True
        self._questions.put((-1, next(self._numbers), None, None))

    def join(self) -> None:
        """Wait for the end."""
        if self._thread.is_alive():
            self._thread.join(FAREWELL_S)

    # --- the thread -------------------------------------------------------------------------

    def _run(self) -> None:
        with contextlib.ExitStack() as stack:
            door: CellLink | None = None
            while True:
                _, _, question, future = self._questions.get()
                if question is None:
                    break
                if future.cancelled():
                    continue
                try:
                    if self._is_deaf:
                        self._is_deaf, door = False, None
                        stack.close()
                    if door is None:
                        door = stack.enter_context(self._open(self._check))
                    self._settle(future.set_result, future, question(door))
                except Ending:
                    self._settle(future.set_exception, future, NodeUnreachable(self._ends))
                except BaseException as error:  # noqa: BLE001 - it is told to whoever asked
                    self._settle(future.set_exception, future, error)
            while not self._questions.empty():
                _, _, question, future = self._questions.get()
                if question is not None:
                    self._settle(future.set_exception, future, NodeUnreachable(self._ends))

    def _check(self) -> None:
        if self._is_ending:
            raise Ending

    def _settle(
        self, settle: Callable[[Any], None], future: asyncio.Future[Any], value: object
    ) -> None:
        def on_loop() -> None:
            if not future.done():
                settle(value)

        with contextlib.suppress(RuntimeError):  # the loop has ended: nobody waits any more
            self._loop.call_soon_threadsafe(on_loop)
