"""The page: what it is made of, and what holds it together."""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import Mapping, Sequence

from bt_orchestrator.base.errors import NodeUnreachable
from bt_orchestrator.extensions.page.web.access import Access
from bt_orchestrator.extensions.page.web.account import ShiftWatch, reason_part
from bt_orchestrator.extensions.page.web.archive.archive import Archive
from bt_orchestrator.extensions.page.web.archive.heard import Heard
from bt_orchestrator.extensions.page.web.board import Board
from bt_orchestrator.extensions.page.web.parts import parts_of
from bt_orchestrator.extensions.page.web.people import People
from bt_orchestrator.extensions.page.web.planning.questions import Questions
from bt_orchestrator.extensions.page.web.scripts.shelf import Shelf
from bt_orchestrator.extensions.page.web.seams import Show, Sources
from bt_orchestrator.extensions.page.web.stream import BEAT_S, Streams
from bt_orchestrator.extensions.page.web.tree_watch import TreeWatch
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.status import CellDescription, CellStatus
from bt_orchestrator.ports import CellLink
from bt_orchestrator.ports.doors.cell_client import CellClient
from bt_orchestrator.ports.doors.following_door import Began, Fact, Happened
from bt_orchestrator.ports.doors.known import Known, told_by
from bt_orchestrator.ports.doors.open_door import OpenDoor
from bt_orchestrator.script.declared import OrderFiles

ASK_AGAIN_S = 30.0
"""A node that did not tell its state is asked again after so long: it may be an older one."""

REFRESH_S = 0.05
"""Shortest time between two computations of the parts."""


class WebPage(CellClient):
    """States: made, started, ended. All but the constructor is called in the server's loop."""

    def __init__(
        self, node: str, open_door: OpenDoor, access: Access, sources: Sources | None = None
    ) -> None:
        """Put the parts together; nothing is started.

        :param node: full name of the node
        """
        super().__init__('page', node, open_door)
        self.sources = sources or Sources()
        self.access = access
        self.people = People(access)
        self.known = Known()
        self.show: Show = CellShow(self.known)
        self.board = Board()
        self.description: CellDescription | None = None
        """The description of the cell; None: not known yet."""
        self._described: tuple[str, int, int] | None = None
        """The cell that a description was asked for: name, sections, components."""
        self._must_describe = True
        """The node may have started anew, with another cell file."""
        self._is_stale = False
        """The parts in the board are not those of the newest status."""
        self._refreshed_at = 0.0
        """On the monotonic clock; 0: never."""
        self._later: asyncio.TimerHandle | None = None

    def _newest(self) -> int:
        return self.board.newest

    def _prepare(self) -> None:
        self.streams = Streams(self.board, self.doors, self._refresh)
        self.questions = Questions(self.sources.planning, self.doors.moment)
        heard = Heard(self.board, self.doors)
        self.archive, own = (
            Archive(heard, self.sources.open_records, lambda: self.board.history) for _ in range(2)
        )
        self.shift = ShiftWatch(self.sources.plant, own, self._tell_shift)
        self.tree = TreeWatch(self._following.do)
        files = OrderFiles(self.sources.trees, self.sources.recipes)
        self.shelf = Shelf(self.known, self.archive, files, self._ask_moment)
        self._spawn(self._beat())
        self._spawn(self.shift.run())

    def _leave(self, door: CellLink) -> None:
        """Keep nothing of a door that will be closed; called in its thread."""
        super()._leave(door)
        self.tree.leave(door)
        with contextlib.suppress(RuntimeError):  # the loop has ended
            self._loop.call_soon_threadsafe(self.tree.close)

    def end(self) -> None:
        """End all streams and refuse further questions; the threads end a moment later."""
        self.streams.end()
        super().end()
        self.people.close()
        self.archive.close()
        self.shift.close()
        self.questions.close()

    @property
    def status(self) -> CellStatus | None:
        """The newest one; None: nothing was heard."""
        return self.board.status

    # --- what is heard ----------------------------------------------------------------------

    def _take(self, facts: Sequence[Fact]) -> None:
        for fact in facts:
            if isinstance(fact, CellStatus):
                self._take_status(fact)
            elif isinstance(fact, Began):
                self.board.begin(fact.history, fact.last)
                self.show.begin(fact.history)
                self._must_describe = True
                self._refreshed_at = 0.0
            else:
                self.board.ring.add(fact)
                if isinstance(fact, Happened):
                    self.show.hear(fact.event)
        if self.streams.readers:
            self._refresh()
            self.streams.wake()

    def _take_status(self, status: CellStatus) -> None:
        if status.history != self.board.history:
            return  # of a node that is gone
        self.board.status = status
        self._is_stale = True
        size = (status.cell, len(status.sections), len(status.components))
        if self._must_describe or size != self._described:
            self._must_describe, self._described = False, size
            self._spawn(self._describe())

    async def _describe(self) -> None:
        try:
            self.description = await self.doors.description()
        except NodeUnreachable:
            self._must_describe = True  # with the next status
        else:
            self.known.cell = None
            self._show_anew()

    async def _ask_moment(self) -> None:
        """Ask for what events have not told: scripts and jobs of before the page began."""
        with contextlib.suppress(KeyError, TypeError, ValueError):  # of another version
            try:
                news = await self.doors.read(lambda door: told_by(door.moment()))
            except NodeUnreachable:
                self._loop.call_later(ASK_AGAIN_S, self.known.not_told)
            else:
                self.known.take(news)
                self._show_anew()

    def _tell_shift(self) -> None:
        self._is_stale = True
        if self.streams.readers:
            self._show_anew()

    def _show_anew(self) -> None:
        self._is_stale = True
        self._refresh()
        self.streams.wake()

    # --- what is shown ----------------------------------------------------------------------

    def _refresh(self) -> None:
        """Bring the parts up to date, but not again and again within a moment."""
        if not self._is_stale or self._later is not None or self.board.status is None:
            return
        wait_s = self._refreshed_at + REFRESH_S - time.monotonic()
        if wait_s > 0:
            self._later = self._loop.call_later(wait_s, self._refresh_now)
        else:
            self._compute()

    def _refresh_now(self) -> None:
        self._later = None
        if self.streams.readers:
            self._compute()
            self.streams.wake()

    def _compute(self) -> None:
        status = self.board.status
        if status is None:
            return
        self._is_stale = False
        parts = self.show.parts(status, self.description, self.node)
        self.board.put({**parts, **reason_part(self.sources.reasons), **self.shift.parts()})
        self._refreshed_at = time.monotonic()
        if self.show.wants_moment:
            self.show.wants_moment = False
            self._spawn(self._ask_moment())

    # --- time -------------------------------------------------------------------------------

    async def _beat(self) -> None:
        while True:
            await asyncio.sleep(BEAT_S)
            self._must_describe |= self.doors.is_silent
            self.streams.beat()


# The view of the page on its cell: parts of the status, with other knowledge.


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
