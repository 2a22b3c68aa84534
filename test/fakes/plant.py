"""Controllers that outlive orchestrators, and the files of a journal."""

from __future__ import annotations

import itertools
from pathlib import Path

from fakes.action_types import FakeActionTypes
from fakes.dying_gateway import DyingGateway
from fakes.line import THREE, Line

from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.model import events as e
from bt_orchestrator.model.jobs.job_commands import AddJobs
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.sim.gateway import VirtualClock
from bt_orchestrator.store.sqlite.restoring import bring_back
from bt_orchestrator.store.sqlite.store import SqliteStore

TYPES = FakeActionTypes()


class Plant:
    """One line whose orchestrators come and go."""

    def __init__(self, folder: Path) -> None:
        self.line = Line()
        self.path = folder / 'journal.sqlite3'
        self.clock = VirtualClock(1_700_000_000.0)
        self.gateway = DyingGateway(self.line.cell, TYPES, self.clock)
        self._goals = (f'00000000-0000-4000-8000-{n:012d}' for n in itertools.count(1))
        self.start(auto_resume=True)

    def start(self, *, auto_resume: bool) -> None:
        self.store = SqliteStore(self.path)
        self.orchestrator = Orchestrator(
            self.line.cell,
            self.gateway,
            self.clock,
            self.store,
            auto_resume=auto_resume,
            new_goal_id=lambda: next(self._goals),
        )
        self.state = self.orchestrator.state

    def end(self) -> None:
        self.orchestrator.close()
        self.store.close()

    def bring_back(self, *, auto_resume: bool = True) -> None:
        """Go on from a copy of the journal, made at this moment."""
        self.end()
        copy = self.path.rename(self.path.with_name('copy.sqlite3'))
        bring_back(copy, self.path)
        self.start(auto_resume=auto_resume)
        self.go()

    def add(self, name: str, text: str = THREE, quantity: int = 2) -> None:
        job = Job(name, self.line.script(text), quantity)
        assert self.orchestrator.ask(AddJobs((job,))).accepted

    def go(self) -> None:
        """Let time pass until nothing more can happen."""
        self.orchestrator.settle()
        while self.state.jobs and self.clock.advance():
            self.orchestrator.settle()

    def go_until_starts(self, task: str) -> None:
        self.orchestrator.settle()
        while not any(key.task == task for key in self.state.running):
            assert self.clock.advance()
            self.orchestrator.settle()

    def events(self, kind: type[e.Event]) -> list[e.Event]:
        return [event for event in self.store.read() if isinstance(event, kind)]

    def holds(self) -> list[str]:
        return [hold.reason for hold in self.state.holds.values()]
