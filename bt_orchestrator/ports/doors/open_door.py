"""How a door is opened, and how the threads with the doors end."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager

from bt_orchestrator.ports import CellLink

OpenDoor = Callable[[Callable[[], object]], AbstractContextManager[CellLink]]
"""Opens a door to the node. Its argument is called again and again while the door waits for the
node; what that raises ends the waiting. Called once in each thread that has a door."""


# How the threads with the doors end.

FAREWELL_S = 1.0
"""Longest wait for a thread: the middleware may hang, and the program ends all the same."""


class Ending(Exception):
    """The program ends."""
