"""The whole queue of a page's cell, also what its status does not list."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from bt_orchestrator.model.frozen import changed
from bt_orchestrator.model.status import CellStatus, JobStatus
from bt_orchestrator.ports import QueuePage

if TYPE_CHECKING:
    from bt_orchestrator.extensions.page.web.page import WebPage


class PageQueue:
    """Implements `endpoints.Queue`."""

    def __init__(self, page: WebPage) -> None:
        self._page = page

    @property
    def queued(self) -> int:
        """Length of the queue, as far as is known."""
        status = self._page.book.status
        return status.queued if status else 0

    async def page(self, after: str, most: int) -> QueuePage:
        """Return jobs of the queue, in order.

        :raises CommandRefused: `after` is not in the queue
        :raises NodeUnreachable: the node does not answer
        """
        return await self._page.doors.queue(after, most)

    def shown(self, jobs: Sequence[JobStatus]) -> Sequence[object]:
        """Return jobs as the page shows those of the status."""
        status = self._page.book.status
        if status is None:
            return ()
        alone: CellStatus = changed(status, jobs=tuple(jobs), sections=(), holds=(), components=())
        parts = self._page.show.parts(alone, self._page.description, self._page.doors.name)
        return [parts[f'job/{job.id}'] for job in jobs]
