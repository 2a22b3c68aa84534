"""The questions of a program to the node."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from bt_orchestrator.base.errors import NodeUnreachable
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.requests import Asked
from bt_orchestrator.model.status import CellDescription
from bt_orchestrator.ports import CellLink, EventPage, Moment, QueuePage
from bt_orchestrator.ports.doors.asking_door import AskingDoor
from bt_orchestrator.ports.doors.following_door import FollowingDoor

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
