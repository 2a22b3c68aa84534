"""The jobs for clients: caught up with the journal first, then followed."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Coroutine
from dataclasses import replace

from bt_orchestrator.base.errors import CommandRefused, NodeUnreachable
from bt_orchestrator.extensions.opcua.mes.followed_jobs import FollowedJobs, News
from bt_orchestrator.extensions.opcua.server.bridge import Bridge
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.status import CellStatus, ListedJob
from bt_orchestrator.ports import CellLink

log = logging.getLogger(__name__)


class Jobs:
    """All calls come from the server's loop."""

    def __init__(
        self,
        bridge: Bridge,
        tell: Callable[[News], object],
        changed: Callable[[], object],
    ) -> None:
        """Know nothing.

        :param tell: called with every change of a job's state, in order
        :param changed: called when more is known of jobs than their status says
        """
        self.followed = FollowedJobs()
        self._bridge = bridge
        self._tell = tell
        self._changed = changed
        self._is_behind = True
        """Earlier events than those that are heard have to be fetched."""
        self._waiting: list[Event] = []
        """Heard meanwhile."""
        self._task: asyncio.Task[None] | None = None
        self._has_missed = False
        """Events are lost: what they told has to be asked for."""
        self._asked: set[str] = set()
        """Jobs that a status has, and nothing else is known of."""

    async def begin(self) -> None:
        """Learn how the jobs stand."""
        status = self._bridge.status
        try:
            listed = await self._bridge.doors.read(_all_jobs)
        except NodeUnreachable as error:
            log.warning('parameters and details of jobs are not known yet: %s', error)
            listed = []
        self.followed.begin(status, listed)

    def forget(self) -> None:
        """Begin anew with the next status: the cell has another journal."""
        if self._task is not None:
            self._task.cancel()
        self._waiting.clear()
        self.followed.begin()
        self._asked.clear()
        self._is_behind = True

    def show(self, status: CellStatus) -> None:
        """Take in a status."""
        if self._is_behind:
            self._is_behind = False
            self._spawn(self._catch_up(is_new=not self.followed.seq))
            return
        if self._task is not None and not self._task.done():
            return
        self.followed.agree(status)
        unknown = {job.id for job in status.jobs if self.followed.get(job.id) is None}
        if self._has_missed or unknown - self._asked:
            self._has_missed = False
            self._asked |= unknown
            self._spawn(self._learn())

    def hear(self, event: Event) -> None:
        """Take in an event."""
        if self._is_behind or (self._task is not None and not self._task.done()):
            self._waiting.append(event)
        else:
            self._follow(event)

    def listed(self, status: CellStatus) -> dict[str, ListedJob]:
        """Return the jobs of a status, and all that ended, with what else is known of them."""
        jobs = {job.status.id: job for job in self.followed.ended()}
        for job in status.jobs:
            known = self.followed.get(job.id)
            jobs[job.id] = ListedJob(job) if known is None else replace(known, status=job)
        return jobs

    async def ask(self, name: str) -> ListedJob | None:
        """Return a job in its present state; None: it is not listed.

        :raises NodeUnreachable: the node does not answer
        """

        def question(door: CellLink) -> ListedJob | None:
            try:
                return door.job(name)
            except CommandRefused:
                return None

        return await self._bridge.doors.read(question)

    # --- what happened meanwhile ------------------------------------------------------------

    def _spawn(self, work: Coroutine[None, None, None]) -> None:
        self._task = asyncio.ensure_future(self._done_first(work))

    async def _done_first(self, work: Coroutine[None, None, None]) -> None:
        """Do something, then follow what was heard meanwhile; with the next status again."""
        try:
            await work
        except NodeUnreachable:
            self._is_behind = True
            self._asked.clear()
            return
        waiting, self._waiting = self._waiting, []
        for event in waiting:
            self._follow(event)
        self._changed()

    async def _catch_up(self, *, is_new: bool) -> None:
        """Follow what happened between the status that was taken first and now."""
        if is_new:
            self.followed.begin(self._bridge.status, await self._bridge.doors.read(_all_jobs))
        while self.followed.seq < self._bridge.newest:
            page = await self._bridge.doors.events_after(self.followed.seq)
            if page.history != self._bridge.history or not page.events:
                return
            for event in page.events:
                self._follow(event)

    async def _learn(self) -> None:
        """Ask for what no event told."""
        self.followed.take(await self._bridge.doors.read(_all_jobs))

    def _follow(self, event: Event) -> None:
        self._has_missed |= event.seq > self.followed.seq + 1
        for news in self.followed.follow(event):
            self._tell(news)


def _all_jobs(door: CellLink) -> list[ListedJob]:
    """Return all listed jobs, page by page."""
    jobs: list[ListedJob] = []
    while True:
        try:
            page = door.jobs(jobs[-1].status.id if jobs else '')
        except CommandRefused:  # it has gone meanwhile: from the first again
            jobs.clear()
            continue
        if not page:
            return jobs
        jobs += page
