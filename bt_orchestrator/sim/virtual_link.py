"""The door to a cell in virtual time."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence

from bt_orchestrator.base.errors import CommandRefused
from bt_orchestrator.base.replies import begin
from bt_orchestrator.engine.runtime import listed_jobs
from bt_orchestrator.engine.runtime.overview import description_of
from bt_orchestrator.engine.tree.branches import branch_of
from bt_orchestrator.model.branch import Branch
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.keeping.snapshot import nearest, state_to_text
from bt_orchestrator.model.limits import EVENTS_PAGE, QUEUE_PAGE
from bt_orchestrator.model.requests import Asked
from bt_orchestrator.model.status import CellDescription, CellStatus, ListedJob
from bt_orchestrator.ports import EventPage, Listener, Moment, QueuePage, Watch
from bt_orchestrator.ports.following import Follower
from bt_orchestrator.sim.virtual_node import VirtualNode


class VirtualLink:
    """Sees one virtual node. Implements `ports.CellLink`; time passes in `turn`."""

    def __init__(self, node: VirtualNode) -> None:
        self._node = node
        self._heard: list[tuple[str, Event]] = []
        self._followers: list[tuple[Listener, Follower]] = []
        self._watches: list[_TreeWatch] = []
        self._heard_at = node.clock.steady()
        self._is_closed = False
        node.add(self)

    @property
    def name(self) -> str:
        """Name of the node."""
        return self._node.name

    def status(self) -> CellStatus:
        """Return how the cell stands."""
        return self._node.running.overview.status(self._node.clock.now())

    def description(self) -> CellDescription:
        """Return what exists in the cell."""
        return description_of(self._node.running.engine.state.cell)

    def follow(self, listener: Listener, after_seq: int | None = None, history: str = '') -> None:
        """Tell a listener what happens, in `turn`."""
        now = self.status()
        last = now.seq if after_seq is None else after_seq
        known = now.history if after_seq is None else history or now.history
        self._followers.append((listener, Follower(listener, known, last)))

    def watch_tree(self, hear: Callable[[Branch], None]) -> Watch:
        """Tell of the behaviour tree, in `turn`, when it has changed."""
        watch = _TreeWatch(hear)
        self._watches.append(watch)
        return watch

    def turn(self, within_s: float) -> None:
        """Let time pass, and tell what happened."""
        self._node.pass_time(within_s)
        heard, self._heard = self._heard, []
        if self._node.is_on:
            self._heard_at = self._node.clock.steady()
        for listener, follower in list(self._followers):
            for history, event in heard:
                if not self._is_closed:
                    follower.heard(history, event)
            if self._node.is_on and not self._is_closed:
                self._catch_up(listener, follower)
        self._watches = [watch for watch in self._watches if not watch.is_closed]
        if self._node.is_on and not self._is_closed:
            for watch in list(self._watches):
                watch.look(branch_of(self._node.running.engine.tree.root))

    @property
    def silent_s(self) -> float:
        """For how long the node has been off, seconds."""
        return self._node.clock.steady() - self._heard_at

    def events_after(self, seq: int, most: int = 0) -> EventPage:
        """Return events from the journal."""
        running = self._node.running
        store, kept = running.store, running.engine.kept_seq
        events = tuple(store.read(seq, min(most or EVENTS_PAGE, EVENTS_PAGE)))
        return EventPage(store.history, events, store.first_seq(), kept)

    def queue(self, after: str = '', most: int = 0) -> QueuePage:
        """Return jobs of the queue."""
        running = self._node.running
        jobs, overview = running.engine.state.jobs, running.overview
        place = jobs.place(after)
        if after and not place:
            raise CommandRefused(f'{after} is not in the queue')
        page = jobs.queue(place + 1, min(most or QUEUE_PAGE, QUEUE_PAGE))
        return QueuePage(tuple(map(overview.job, page)), jobs.waiting)

    def jobs(self, after: str = '', most: int = 0) -> Sequence[ListedJob]:
        """Return listed jobs."""
        running = self._node.running
        return listed_jobs.page(running.engine.state, running.overview, after, most)

    def job(self, name: str) -> ListedJob:
        """Return a listed job."""
        running = self._node.running
        return listed_jobs.told_of(listed_jobs.find(running.engine.state, name), running.overview)

    def moment(self) -> Moment:
        """Return the state of now."""
        state = self._node.running.engine.state
        plain = json.loads(state_to_text(nearest(state, with_ids=True)))
        return Moment(state.cell, plain, self._node.clock.now())

    def ask(self, asked: Asked) -> Answer:
        """Ask something of the cell."""
        return begin(self._node.running.handler.carry_out(asked)).value

    def close(self) -> None:
        """Leave."""
        if not self._is_closed:
            self._is_closed = True
            self._followers.clear()
            self._watches.clear()
            self._node.remove(self)

    def hear(self, history: str, event: Event) -> None:
        """Keep an event for the next turn."""
        self._heard.append((history, event))

    def _catch_up(self, listener: Listener, follower: Follower) -> None:
        status = self.status()
        follower.told(status.history, status.seq)
        while (after := follower.next_fetch()) is not None and not self._is_closed:
            follower.fetched(self.events_after(after))
        if not self._is_closed:
            listener.on_status(status)


class _TreeWatch:
    """Tells of the tree, whenever it is another one. Implements `ports.Watch`."""

    def __init__(self, hear: Callable[[Branch], None]) -> None:
        self._hear = hear
        self._known: Branch | None = None
        self.is_closed = False

    def close(self) -> None:
        """Stop reporting."""
        self.is_closed = True

    def look(self, tree: Branch) -> None:
        """Look at the tree of now."""
        if not self.is_closed and tree != self._known:
            self._known = tree
            self._hear(tree)
