"""A line whose orchestrators are killed and followed by others."""

from __future__ import annotations

import itertools

from fakes.action_types import FakeActionTypes
from fakes.clocks import SetClock
from fakes.dying_gateway import DyingGateway

from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.jobs.job_commands import AddJobs
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.script import Script
from bt_orchestrator.ports import EventStore
from bt_orchestrator.store.memory import MemoryStore

TYPES = FakeActionTypes()


class World:
    """Controllers and a journal that outlive orchestrators."""

    def __init__(self, cell: Cell, store: EventStore | None = None) -> None:
        self.cell = cell
        self.clock = SetClock()
        self.gateway = DyingGateway(cell, TYPES, self.clock)
        self.store = store or MemoryStore()
        self._goals = (f'00000000-0000-4000-8000-{n:012d}' for n in itertools.count(1))

    def orchestrator(self, *, auto_resume: bool = True) -> Orchestrator:
        return Orchestrator(
            self.cell,
            self.gateway,
            self.clock,
            self.store,
            auto_resume=auto_resume,
            new_goal_id=lambda: next(self._goals),
        )

    def go(self, orchestrator: Orchestrator, settles: int = 10_000) -> None:
        for _ in range(settles):
            orchestrator.settle()
            if not orchestrator.state.jobs or not self.clock.advance():
                return

    def go_until_runs(self, orchestrator: Orchestrator, task: str) -> None:
        self.go_until_starts(orchestrator, task)
        self.clock.advance()  # the request reaches the server

    def go_until_starts(self, orchestrator: Orchestrator, task: str) -> None:
        orchestrator.settle()
        while not any(key.task == task for key in orchestrator.state.running):
            assert self.clock.advance()
            orchestrator.settle()

    def events(self, kind: type[e.Event]) -> list[e.Event]:
        return [event for event in self.store.read() if isinstance(event, kind)]


def begun(world: World, script: Script, quantity: int = 3) -> Orchestrator:
    orchestrator = world.orchestrator()
    assert orchestrator.ask(AddJobs((Job('J', script, quantity),))).accepted
    return orchestrator


def killed_at_work(world: World, script: Script, quantity: int = 1) -> Orchestrator:
    """Kill an orchestrator while the task `work` of its job runs, and return it."""
    first = begun(world, script, quantity)
    world.go_until_runs(first, 'work')
    first.close()
    return first
