"""How a door is opened."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager

from bt_orchestrator.ports import CellLink

OpenDoor = Callable[[Callable[[], object]], AbstractContextManager[CellLink]]
"""Opens a door to the node. Its argument is called again and again while the door waits for the
node; what that raises ends the waiting. Called once in each thread that has a door."""
