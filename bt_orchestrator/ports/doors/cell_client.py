"""A program at the door of a cell: it follows and asks, and its loop never waits for the node."""

from __future__ import annotations

import abc
import asyncio
import contextlib
from collections.abc import Callable, Coroutine, Sequence
from typing import Any

from bt_orchestrator.ports import CellLink
from bt_orchestrator.ports.doors.doors import AskingDoor, Doors
from bt_orchestrator.ports.doors.following_door import Fact, FollowingDoor
from bt_orchestrator.ports.doors.open_door import OpenDoor
from bt_orchestrator.ports.doors.tickets import Tickets


class CellClient(abc.ABC):
    """States: made, started, ended. All but the constructor is called in the program's loop.

    :ivar doors: what may be asked of the node; there from `start` on
    :ivar tickets: commands that are done once; there from `start` on
    """

    doors: Doors
    tickets: Tickets

    def __init__(self, program: str, node: str, open_door: OpenDoor) -> None:
        """Put the threads together; nothing is started.

        :param program: its name, for threads and messages
        :param node: full name of the node
        """
        self.node = node
        self._program = program
        self._open_door = open_door
        self._following = FollowingDoor(program, open_door, self._hand_over)
        self._tasks: set[asyncio.Task[None]] = set()

    def start(self, on_error: Callable[[], object]) -> None:
        """Begin to follow the cell, in the running loop.

        :param on_error: called in another thread if it cannot go on (`error`)
        """
        self._loop = asyncio.get_running_loop()
        self._asking = AskingDoor(self._program, self._open_door, self._loop)
        self.doors = Doors(self.node, self._following, self._asking)
        self.tickets = Tickets(self.doors, self._newest)
        self._following.on_error = on_error
        self._following.on_deaf = self._leave
        self._prepare()
        self._following.start()
        self._asking.start()
        self._spawn(self._open_early())

    def end(self) -> None:
        """Refuse further questions; the threads end a moment later."""
        self._following.end()
        self._asking.end()
        for task in self._tasks:
            task.cancel()

    def join(self) -> None:
        """Wait for the end of the threads; the loop may have ended."""
        self._following.join()
        self._asking.join()

    @property
    def error(self) -> BaseException | None:
        """Why it cannot go on."""
        return self._following.error

    # --- of each program --------------------------------------------------------------------

    @abc.abstractmethod
    def _newest(self) -> int:
        """Return the last event that was heard of."""

    @abc.abstractmethod
    def _prepare(self) -> None:
        """Make what needs the doors; nothing was heard yet."""

    @abc.abstractmethod
    def _take(self, facts: Sequence[Fact]) -> None:
        """Take what was heard, in order."""

    def _leave(self, door: CellLink) -> None:
        """Keep nothing of a door that will be closed; called in its thread."""
        del door
        self._asking.renew()

    # --- for them ---------------------------------------------------------------------------

    def _spawn(self, work: Coroutine[Any, Any, None]) -> None:
        """Run something until it, or the program, ends."""
        task = asyncio.create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def _hand_over(self, facts: Sequence[Fact]) -> None:
        """Hand facts to the loop; called in the thread that follows."""
        with contextlib.suppress(RuntimeError):  # the loop has ended
            self._loop.call_soon_threadsafe(self._take, facts)

    async def _open_early(self) -> None:
        """Open the door for questions: an abort must not wait until ROS is loaded."""
        with contextlib.suppress(Exception):  # whoever asks something is told
            await self._asking.call(lambda _: None)
