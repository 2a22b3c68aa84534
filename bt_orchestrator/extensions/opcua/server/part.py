"""The work of each part of the server: the flat one, job control, PackML, holds."""

from __future__ import annotations

from typing import Protocol

from bt_orchestrator.extensions.opcua.server.space import Space
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.status import CellStatus


class Part(Protocol):
    """A part of the address space. All calls come from the server's loop.

    It lives as long as what exists in the cell stays the same; for another cell file it is made
    anew, and clients connect again.
    """

    async def build(self, space: Space) -> None:
        """Make the nodes and methods; no client is there yet, and the status is known."""

    def show(self, status: CellStatus) -> None:
        """Show a new status (`Values.put`); first right after `build`."""

    def hear(self, event: Event) -> None:
        """Take note of an event: each one since `build`, once and in order."""

    def begin(self, history: str) -> None:
        """Forget what was: the cell has another journal. Its status is shown next."""
