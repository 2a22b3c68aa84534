"""A journal that was brought back from a copy: the line may be further than it says (9.2)."""

from __future__ import annotations

import itertools
from pathlib import Path

import pytest
from fakes.action_types import FakeActionTypes
from fakes.dying_gateway import DyingGateway
from fakes.line import THREE, Line, with_section
from fakes.operator import ann

from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell_commands import Resume
from bt_orchestrator.model.job_commands import AddJobs
from bt_orchestrator.model.order import Job
from bt_orchestrator.runtime.orchestrator import Orchestrator
from bt_orchestrator.sim.clock import VirtualClock
from bt_orchestrator.store.restoring import bring_back
from bt_orchestrator.store.sqlite import SqliteStore

TYPES = FakeActionTypes()


class Plant:
    """Controllers that outlive orchestrators, and the files of a journal."""

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


@pytest.fixture
def plant(tmp_path: Path) -> Plant:
    return Plant(tmp_path)


def assert_waits(plant: Plant) -> None:
    """Nothing starts, whatever is said but the number of the hold."""
    before = len(plant.events(e.TaskStarted))
    for everyones in (False, True):
        resume = Resume(ann('go'), everyones=everyones)
        assert not plant.orchestrator.ask(resume).accepted
        plant.go()
    assert len(plant.events(e.TaskStarted)) == before
    assert plant.holds() == ['restored']


def release(plant: Plant) -> None:
    (hold,) = plant.state.holds
    assert plant.orchestrator.ask(Resume(ann('compared'), hold)).accepted
    plant.go()


@pytest.mark.parametrize('auto_resume', [True, False])
def test_9_2_work_of_a_copy_waits_until_somebody_has_looked(
    plant: Plant, *, auto_resume: bool
) -> None:
    plant.add('ON-THE-LINE')
    plant.add('QUEUED')
    plant.go_until_starts('pack')
    plant.clock.advance()
    plant.bring_back(auto_resume=auto_resume)
    assert_waits(plant)
    (hold,) = plant.state.holds.values()
    assert 'a copy that ends with event' in hold.message
    assert 'of 2023-11-14 22:13:' in hold.message
    assert '2 unfinished jobs, 3 goals in flight' in hold.message
    release(plant)
    assert {name: job.progress.packed for name, job in plant.state.ended.items()} == {
        'ON-THE-LINE': 2,
        'QUEUED': 2,
    }
    plant.end()


def test_9_2_a_copy_of_an_idle_cell_waits_too(plant: Plant) -> None:
    plant.add('BEFORE')
    plant.go()
    plant.bring_back()
    plant.add('NEXT')
    assert_waits(plant)
    release(plant)
    assert not plant.state.jobs
    plant.end()


def test_9_2_a_copy_is_looked_at_once(plant: Plant) -> None:
    plant.add('J')
    plant.go_until_starts('work')
    plant.clock.advance()  # the requests reach their servers
    plant.bring_back()
    plant.end()
    plant.start(auto_resume=True)
    plant.go()
    assert_waits(plant)  # a restart in between is no look
    release(plant)
    assert not plant.state.jobs
    plant.end()
    plant.start(auto_resume=True)
    assert plant.holds() == []
    plant.orchestrator.settle()
    started = plant.events(e.OrchestratorStarted)
    assert [x.restored for x in started] == [False, True, False, False]  # type: ignore[attr-defined]
    assert len({x.history for x in started}) == 2  # type: ignore[attr-defined]
    plant.end()


@pytest.mark.parametrize('repeatable', ['true', 'false'])
def test_9_2_a_goal_in_flight_of_a_copy_is_not_sent_again(plant: Plant, repeatable: str) -> None:
    work = f'- {{id: work, @a2.TASK_B, repeatable: {repeatable}}}'
    plant.gateway.unsent = 'TASK_B'
    plant.add('J', with_section(2, work), 1)
    plant.go_until_starts('work')
    plant.gateway.unsent = None
    plant.bring_back()
    assert sorted(plant.holds()) == ['in_doubt', 'restored']
    assert not plant.events(e.TaskResent)
    plant.end()


def test_9_2_without_a_copy_the_same_goal_is_sent(plant: Plant) -> None:
    plant.gateway.unsent = 'TASK_B'
    plant.add('J', with_section(2, '- {id: work, @a2.TASK_B}'), 1)
    plant.go_until_starts('work')
    plant.gateway.unsent = None
    plant.end()
    plant.start(auto_resume=True)
    plant.go()
    assert len(plant.events(e.TaskResent)) == 1
    assert not plant.state.jobs
    plant.end()
