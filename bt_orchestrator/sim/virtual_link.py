"""The door to a cell in virtual time."""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Protocol

from bt_orchestrator.base.errors import CommandRefused, NodeUnreachable
from bt_orchestrator.base.replies import begin
from bt_orchestrator.engine.asking.handler import RequestHandler
from bt_orchestrator.engine.asking.orders import DeskHere
from bt_orchestrator.engine.runtime import listed_jobs
from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.engine.runtime.overview import Overview, description_of
from bt_orchestrator.engine.tree.root import branch_of
from bt_orchestrator.model.branch import Branch
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.keeping.snapshot import nearest, state_to_text
from bt_orchestrator.model.limits import EVENTS_PAGE, QUEUE_PAGE
from bt_orchestrator.model.requests import Asked
from bt_orchestrator.model.status import CellDescription, CellStatus, ListedJob
from bt_orchestrator.ports import (
    ActionTypes,
    EventPage,
    EventStore,
    Listener,
    Moment,
    QueuePage,
    Watch,
)
from bt_orchestrator.ports.following import Follower
from bt_orchestrator.sim.gateway import VirtualClock, VirtualGateway


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
        running = self._node.running
        return description_of(running.engine.state.cell, running.types)

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


# A tree node in virtual time, as people and machines outside see one.


class Hearer(Protocol):
    """Hears what a node says, as a client of its events topic does."""

    def hear(self, history: str, event: Event) -> None:
        """Take in an event."""


class Running:
    """The parts that exist as long as the node runs."""

    def __init__(
        self, engine: Orchestrator, store: EventStore, types: ActionTypes, trees: Sequence[Path]
    ) -> None:
        cell, state = engine.state.cell, engine.state
        self.engine = engine
        self.store = store
        self.types = types
        self.overview = Overview(engine)
        self.handler = RequestHandler(engine, types, DeskHere(cell, types, trees, state))


class VirtualNode:
    """States: off, on. Robots, journal, clock and listeners outlive the engine.

    Implements `ports.EventSink`.
    """

    def __init__(
        self,
        cell: Cell,
        types: ActionTypes,
        trees: Sequence[Path] = (),
        *,
        name: str = '/bt_orchestrator',
        start_s: float = 0.0,
    ) -> None:
        """Put up the robots.

        :param trees: folders in which scripts of orders are looked up
        :param start_s: time at which they begin
        """
        self.name = name
        self.cell = cell
        self.clock = VirtualClock(start_s)
        self._types = types
        self._trees = tuple(trees)
        self._gateway = VirtualGateway(cell, types, self.clock)
        self._goals = (f'00000000-0000-0000-0000-{n:012x}' for n in itertools.count(1))
        self._hearers: list[Hearer] = []
        self._running: Running | None = None

    @property
    def running(self) -> Running:
        """The present runs.

        :raises NodeUnreachable: it is off
        """
        if self._running is None:
            raise NodeUnreachable(f'{self.name} does not answer: it is switched off')
        return self._running

    @property
    def is_on(self) -> bool:
        """Tell whether it runs."""
        return self._running is not None

    def switch_on(self, store: EventStore, *, auto_resume: bool = True) -> None:
        """Start an engine with a journal, which may have the events of one before."""
        engine = Orchestrator(
            self.cell,
            self._gateway,
            self.clock,
            store,
            [self],
            auto_resume=auto_resume,
            new_goal_id=lambda: next(self._goals),
        )
        self._running = Running(engine, store, self._types, self._trees)
        engine.settle()

    def switch_off(self) -> None:
        """End at once, like a killed process; goals go on, without any message."""
        self.running.engine.close()
        self._running = None

    def pass_time(self, seconds: float) -> None:
        """Let time pass, for the robots too."""
        over: list[bool] = []
        self.clock.call_at(self.clock.steady() + seconds, lambda: over.append(True))
        while not over:
            self.clock.advance()
            if self._running is not None:
                self._running.engine.settle()

    def add(self, hearer: Hearer) -> None:
        """Add a listener for all further events."""
        self._hearers.append(hearer)

    def remove(self, hearer: Hearer) -> None:
        """Remove a listener."""
        self._hearers.remove(hearer)

    def publish(self, events: Sequence[Event]) -> None:
        """Send events to all listeners."""
        history = self.running.store.history if self._running is not None else ''
        for event in events:
            for hearer in self._hearers:
                hearer.hear(history, event)
