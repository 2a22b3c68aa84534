"""A journal as long as one likes: job after job, by the real engine in virtual time."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from pathlib import Path

from fakes.action_types import FakeActionTypes
from fakes.line import THREE, Line

from bt_orchestrator.engine.runtime.housekeeping import Housekeeping
from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.model.jobs.job_commands import AddJobs
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.ports import Bookkeeping
from bt_orchestrator.sim.gateway import VirtualClock, VirtualGateway
from bt_orchestrator.store.sqlite.store import SqliteStore

TYPES = FakeActionTypes()


class LongRun:
    """One cell with a journal in a file, its orchestrator and its housekeeping."""

    def __init__(
        self,
        path: Path,
        line: Line | None = None,
        *,
        keep_jobs: int = -1,
        synchronous: str = 'NORMAL',
        bookkeeping: Bookkeeping | None = None,
    ) -> None:
        self.line = line or Line()
        self.clock = VirtualClock()
        self.store = SqliteStore(path, synchronous=synchronous)
        goals = itertools.count(self.store.first_seq() + sum(1 for _ in self.store.read()))
        self.orchestrator = Orchestrator(
            self.line.cell,
            VirtualGateway(self.line.cell, TYPES, self.clock),
            self.clock,
            self.store,
            auto_resume=True,
            new_goal_id=lambda: f'00000000-0000-4000-8000-{next(goals):012d}',
        )
        self.housekeeping = Housekeeping(
            self.orchestrator.state, self.store, keep_jobs, bookkeeping=bookkeeping
        )

    def job(self, name: str, quantity: int = 3, text: str = THREE) -> None:
        """Run one job to its end, with a quiet moment whenever time passes."""
        assert self.orchestrator.ask(
            AddJobs((Job(name, self.line.script(text), quantity),))
        ).accepted
        self.go(lambda: not self.orchestrator.state.jobs)

    def go(self, until: Callable[[], bool]) -> None:
        """Let time pass until a condition holds."""
        while not until():
            assert self.clock.advance()
            self.orchestrator.settle()
            self.housekeeping.turn(quiet=False)
            self.rest(1)

    def rest(self, turns: int) -> None:
        """Let the housekeeping have quiet moments."""
        for _ in range(turns):
            assert not self.orchestrator.settle()
            self.housekeeping.turn(quiet=True)

    def close(self) -> None:
        """End in order: the next start finds a snapshot of the last event."""
        self.housekeeping.finish()
        self.kill()

    def kill(self) -> None:
        """End as a killed process does."""
        self.orchestrator.close()
        self.store.close()


def make_long_journal(
    path: Path, events: int, *, quantity: int = 100, line: Line | None = None, text: str = THREE
) -> int:
    """Write a journal of at least so many events; returns how many they are.

    :param text: of the script that the line runs
    """
    run = LongRun(path, line)
    for number in itertools.count(1):
        run.job(f'WO-{number}', quantity, text)
        if run.orchestrator.state.seq >= events:
            break
    seq = run.orchestrator.state.seq
    run.close()
    return seq
