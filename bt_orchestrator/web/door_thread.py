"""The doors of the page, each in a thread of its own: one follows the cell, the other asks.

The server's loop never waits for the node: what happens is handed to it in batches, and what is
asked comes back as an awaitable.
"""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import queue
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from bt_orchestrator.errors import NodeUnreachable
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.requests import Asked
from bt_orchestrator.model.status import CellDescription, CellStatus
from bt_orchestrator.ports import CellLink, EventPage, Moment, QueuePage
from bt_orchestrator.web.ring import Happened, Lost
from bt_orchestrator.web.seams import OpenDoor

_T = TypeVar('_T')

STEP_S = 0.1
"""Longest time between two looks at whether to end."""

AGAIN_S = 1.0
"""Pause before another door is opened, when the node could not tell its events at the last one."""

STEADY_S = 5.0
"""A node that could not tell its events counts as silent until it has told them for so long."""

FAREWELL_S = 1.0
"""Longest wait for a thread: the middleware may hang, and the page ends all the same."""

SILENT_S = 3.0
"""A node that says nothing for so long is away: it says something once a second."""

DEAF_S = 10.0
"""After such a silence the doors are opened anew. A process that stood still for longer than DDS
waits for a sign of life (20 s) does not hear the others again, nor do they hear it."""


class Ending(Exception):
    """The page ends."""


@dataclass(frozen=True)
class Began:
    """A history, and the event after which its events will be told."""

    history: str
    last: int


Fact = Began | Happened | Lost | CellStatus


class FollowingDoor:
    """Follows the cell for as long as the page runs. Implements `ports.Listener`."""

    def __init__(self, open_door: OpenDoor, tell: Callable[[Sequence[Fact]], object]) -> None:
        """Prepare.

        :param tell: called in the thread with what was heard, in order; hands it to the loop
        """
        self._open = open_door
        self._tell = tell
        self._facts: list[Fact] = []
        self._door: CellLink | None = None
        """None: there was none yet."""
        self._unheard_since: float | None = time.monotonic()
        """Since when the node is not followed; None: it is."""
        self._well_from = 0.0
        """When the node, which is followed again, counts as heard."""
        self._to_do: queue.SimpleQueue[Callable[[CellLink], object]] = queue.SimpleQueue()
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._run, name='page: following', daemon=True)
        self.error: BaseException | None = None
        """Why the thread ended by itself; None: it has not."""
        self.on_error: Callable[[], object] = _nothing
        self.on_deaf: Callable[[CellLink], object] = _nothing
        """Called in the thread with a door that will be closed, and another one opened."""
        self._place: Began | None = None
        """How far it has followed; None: it has not begun."""

    def start(self) -> None:
        """Begin to follow."""
        self._thread.start()

    @property
    def silent_s(self) -> float:
        """For how long nothing was heard of the node, seconds; from any thread."""
        since = self._unheard_since
        if since is not None:
            return time.monotonic() - since
        assert self._door is not None
        return self._door.silent_s

    def do(self, work: Callable[[CellLink], object]) -> None:
        """Have something done in the thread between two turns of its door; from any thread.

        :param work: waits for nothing
        """
        self._to_do.put(work)

    def end(self) -> None:
        """Ask the thread to end; it does within STEP_S."""
        self._ending.set()

    def join(self) -> None:
        """Wait for the end."""
        if self._thread.is_alive():
            self._thread.join(FAREWELL_S)

    # --- the listener -----------------------------------------------------------------------

    def on_status(self, status: CellStatus) -> None:
        """Take note."""
        self._facts.append(status)

    def on_event(self, event: Event) -> None:
        """Take note."""
        self._facts.append(Happened(event))
        self._go_on(event.seq)

    def on_gap(self, first: int, last: int) -> None:
        """Take note."""
        self._facts.append(Lost(first, last))
        self._go_on(last)

    def on_history(self, history: str) -> None:
        """Take note."""
        self._begin(history, 0)

    def _begin(self, history: str, last: int) -> Began:
        place = self._place = Began(history, last)
        self._facts.append(place)
        return place

    def _go_on(self, last: int) -> None:
        assert self._place is not None
        self._place = Began(self._place.history, last)

    # --- the thread -------------------------------------------------------------------------

    def _run(self) -> None:
        try:
            while True:
                with self._open(self._check) as door:
                    self._follow(door)
                    self._hear(door)
                    self.on_deaf(door)
        except Ending:
            pass
        except BaseException as error:  # noqa: BLE001 - it is told where the page was started
            self.error = error
            self.on_error()

    def _check(self) -> None:
        if self._ending.is_set():
            raise Ending

    def _follow(self, door: CellLink) -> None:
        """Begin to follow, however long the node is not there."""
        while True:
            self._check()
            try:
                place = self._place or self._begin_at_end(door)
                door.follow(self, place.last, place.history)
            except NodeUnreachable:
                self._ending.wait(STEP_S)
            else:
                self._door = door
                return

    def _begin_at_end(self, door: CellLink) -> Began:
        """Begin after what has happened so far."""
        status = door.status()
        # The status tells of an event a moment after it has happened, the journal at once.
        page = door.events_after(status.seq, 1)
        return self._begin(page.history, page.last_seq)

    def _hear(self, door: CellLink) -> None:
        """Hear what happens, until nothing is heard any more, or the node cannot tell it."""
        while door.silent_s < DEAF_S:
            self._check()
            if time.monotonic() >= self._well_from:
                self._unheard_since = None
            if not self._turn(door):
                self._unheard_since = self._unheard_since or time.monotonic()
                self._well_from = time.monotonic() + STEADY_S
                self._ending.wait(AGAIN_S)
                return
        self._unheard_since = time.monotonic() - door.silent_s

    def _turn(self, door: CellLink) -> bool:
        """Turn once, and hand on what was heard; tells whether the node can tell its events."""
        while not self._to_do.empty():
            self._to_do.get()(door)
        try:
            door.turn(STEP_S)
        except NodeUnreachable:
            return False
        finally:
            if self._facts:
                facts, self._facts = self._facts, []
                self._tell(facts)
        return True


class AskingDoor:
    """Asks the node one question after the other, commands first."""

    COMMAND, READING = 0, 1

    def __init__(self, open_door: OpenDoor, loop: asyncio.AbstractEventLoop) -> None:
        self._open = open_door
        self._loop = loop
        self._numbers = itertools.count()
        self._questions: queue.PriorityQueue[tuple[int, int, Any, Any]] = queue.PriorityQueue()
        self._is_ending = False
        self._is_deaf = False
        self._thread = threading.Thread(target=self._run, name='page: asking', daemon=True)

    def start(self) -> None:
        """Be ready; the door is opened with the first question, which takes a second or two."""
        self._thread.start()

    async def call(self, question: Callable[[CellLink], _T], urgency: int = READING) -> _T:
        """Return what a question to the door comes to.

        :raises NodeUnreachable: the node does not answer, or the page ends
        """
        future: asyncio.Future[_T] = self._loop.create_future()
        if self._is_ending:
            raise NodeUnreachable('the page ends')
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
                    self._settle(future.set_exception, future, NodeUnreachable('the page ends'))
                except BaseException as error:  # noqa: BLE001 - it is told to whoever asked
                    self._settle(future.set_exception, future, error)
            while not self._questions.empty():
                _, _, question, future = self._questions.get()
                if question is not None:
                    self._settle(future.set_exception, future, NodeUnreachable('the page ends'))

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


class Doors:
    """What the page asks of the node. Each raises NodeUnreachable if the node does not answer.

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
            raise NodeUnreachable(f'{self.name} has been silent for {self.silent_s:.0f} s')
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


def _nothing(*_: object) -> None:
    """Placeholder until somebody listens."""
