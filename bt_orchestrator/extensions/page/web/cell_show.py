"""The view of the page on its cell: parts of the status, with other knowledge."""

from __future__ import annotations

from collections.abc import Mapping

from bt_orchestrator.extensions.page.web.parts import parts_of
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.status import CellDescription, CellStatus
from bt_orchestrator.ports.doors.known import Known


class CellShow:
    """Implements `seams.Show`."""

    def __init__(self, known: Known) -> None:
        self._known = known
        self.wants_moment = False

    def begin(self, history: str) -> None:  # noqa: ARG002 - the seam's
        """Forget what was known of the jobs of another journal."""
        self._known.begin()

    def hear(self, event: Event) -> None:
        """Take note of an event."""
        self._known.hear(event)

    def parts(
        self, status: CellStatus, description: CellDescription | None, node: str
    ) -> Mapping[str, object]:
        """Return everything that is shown."""
        self.wants_moment |= self._known.lacks(job.digest for job in status.jobs)
        described = description or CellDescription(status.cell, len(status.sections), '')
        return parts_of(status, described, self._known.scripts, node, self._known.orders)
