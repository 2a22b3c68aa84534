"""A tree node in virtual time, as people and machines outside see one."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

from bt_orchestrator.base.errors import NodeUnreachable
from bt_orchestrator.engine.asking.desk_here import DeskHere
from bt_orchestrator.engine.asking.handler import RequestHandler
from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.engine.runtime.overview import Overview
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.events import Event
from bt_orchestrator.ports import ActionTypes, EventStore
from bt_orchestrator.sim.clock import VirtualClock
from bt_orchestrator.sim.gateway import VirtualGateway


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
