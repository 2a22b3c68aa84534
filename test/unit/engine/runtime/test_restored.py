"""A journal that was brought back from a copy: the line may be further than it says (9.2)."""

from __future__ import annotations

from pathlib import Path

import pytest
from fakes.commands import Resume
from fakes.line import with_section
from fakes.operator import ann
from fakes.plant import Plant

from bt_orchestrator.model import events as e


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
def test_9_2_work_of_copy_waits_until_checked(plant: Plant, *, auto_resume: bool) -> None:
    plant.add('ON-THE-LINE')
    plant.add('QUEUED')
    plant.go_until_starts('pack')
    plant.clock.advance()
    plant.bring_back(auto_resume=auto_resume)
    assert_waits(plant)
    (hold,) = plant.state.holds.values()
    assert 'a copy that ends with event' in hold.message
    assert 'of 2023-11-14 22:13:' in hold.message
    assert 'unfinished jobs: 2, goals in flight: 3' in hold.message
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
def test_9_2_goal_in_flight_of_copy_is_not_resent(plant: Plant, repeatable: str) -> None:
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
