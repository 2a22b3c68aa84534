"""The door that asks the node, in a thread of its own; answers come back as awaitables."""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import queue
import threading
from collections.abc import Callable
from typing import Any, TypeVar

from bt_orchestrator.base.errors import NodeUnreachable
from bt_orchestrator.ports import CellLink
from bt_orchestrator.ports.doors.ending import FAREWELL_S, Ending
from bt_orchestrator.ports.doors.open_door import OpenDoor

_T = TypeVar('_T')


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
