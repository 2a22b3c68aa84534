"""A virtual run of the real tree: the same engine, with time and robots that are numbers."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Sequence
from enum import Enum

from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.engine.runtime.overview import Overview
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.goal import GoalRequest
from bt_orchestrator.model.jobs.job_commands import AddJobs
from bt_orchestrator.model.jobs.needs import awaits_release
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.requests import RELEASE_SCRIPT, Asked
from bt_orchestrator.model.state import CellState
from bt_orchestrator.model.status import CellStatus
from bt_orchestrator.model.wait import PartWait, Wait, WaitKind
from bt_orchestrator.ports import ActionTypes, EventSink, EventStore
from bt_orchestrator.sim.gateway import VirtualClock, VirtualGateway


class Outcome(Enum):
    """How a virtual run ended."""

    FINISHED = 'finished'
    """Every job ended."""
    HELD = 'held'
    """An operator would have to answer."""
    STUCK = 'stuck'
    """Nothing runs, nothing can start, and no operator is asked."""


class Simulation:
    """A cell in virtual time, from the first order to the end of the last."""

    def __init__(
        self,
        cell: Cell,
        types: ActionTypes,
        store: EventStore,
        sinks: Sequence[EventSink] = (),
        *,
        duration: Callable[[GoalRequest], float] | None = None,
        auto_start: bool = True,
        robots: Callable[..., VirtualGateway] = VirtualGateway,
    ) -> None:
        """Switch the cell on at time 0.

        :param duration: seconds that a goal takes; without it the cell file's nominal ones
        :param robots: makes the robots, of the same arguments as `VirtualGateway`
        :param auto_start: it resets and starts by itself when an order arrives
        """
        self.clock = VirtualClock()
        numbers = itertools.count(1)
        self.gateway = robots(cell, types, self.clock, duration=duration)
        self.orchestrator = Orchestrator(
            cell,
            self.gateway,
            self.clock,
            store,
            sinks,
            auto_start=auto_start,
            # Counted, so that two runs of one line have the same trace.
            new_goal_id=lambda: f'00000000-0000-0000-0000-{next(numbers):012x}',
        )
        self._overview = Overview(self.orchestrator)

    @property
    def state(self) -> CellState:
        """The state now."""
        return self.orchestrator.state

    def submit(self, jobs: Iterable[Job]) -> list[Answer]:
        """Queue jobs now, in order; what has to be released is released (semantics 6.10)."""
        return [self._queued(job) for job in jobs]

    def _queued(self, job: Job) -> Answer:
        if awaits_release(self.state, job.script):
            self.orchestrator.ask(Asked(RELEASE_SCRIPT, None, {'script': digest(job.script)}))
        return self.orchestrator.ask(AddJobs((job,)))

    def run(self, look: Callable[[], None] = lambda: None) -> Outcome:
        """Let time pass until nothing more can happen.

        :param look: called after every settle: nothing changes from then until time moves on
        """
        self.orchestrator.settle()
        look()
        while self.state.jobs and self.clock.advance():
            self.orchestrator.settle()
            look()
        if not self.state.jobs:
            return Outcome.FINISHED
        return Outcome.HELD if self.state.holds else Outcome.STUCK

    def waits(self) -> list[PartWait]:
        """Return the present waits."""
        return self._overview.waits()

    def status(self) -> CellStatus:
        """Return how the cell stands now, as a node would tell it."""
        return self._overview.status(self.clock.now())

    def close(self) -> None:
        """Give the engine up."""
        self.orchestrator.close()


# Why a virtual run does not go on: the waits that matter, and the goals that never end.


def standstill(state: CellState, waits: Sequence[PartWait]) -> list[PartWait]:
    """Return the waits, in the order of the belt.

    A section without work that only waits for the line is left out, unless a part with work waits
    for it.
    """
    awaited = {n for wait in waits if _has_work(state, wait) for n in wait.wait.sections}
    relevant = [wait for wait in waits if _has_work(state, wait) or wait.section in awaited]
    return [*relevant, *_endless(state)]


def _has_work(state: CellState, wait: PartWait) -> bool:
    return wait.section is None or state.sections[wait.section].cycle is not None


def _endless(state: CellState) -> Iterator[PartWait]:
    """Name the goals in flight: when time stands still, nothing will end them."""
    for key, task in state.running.items():
        definition = state.task(key)
        component = (
            state.cell.conveyor.component.name if definition is None else definition.component
        )
        what = f'{key} runs since {task.started:g} s and will never end'
        yield PartWait(component, Wait(what, WaitKind.COMPONENT, component, task=key.task))
