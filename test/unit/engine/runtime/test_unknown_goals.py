"""Goals at a server that the journal does not know, and those it may send again (9.2)."""

from __future__ import annotations

import pytest
from fakes.commands import Abort, Pause, Resume
from fakes.line import THREE, Line, with_section
from fakes.operator import ann
from fakes.world import World, begun, killed_at_work

from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.model import events as e
from bt_orchestrator.model.goal import Contest, SeenContest
from bt_orchestrator.model.jobs.job_commands import AddJobs
from bt_orchestrator.model.jobs.order import Job

STRANGE = '5b6c0000-0000-4000-8000-000000000001'
ACCEPTED_S = 1_700_000_000.0


def find(world: World, *goals: str, before: bool = True) -> None:
    """Let the server of a2 be found with goals that run there."""
    known = dict.fromkeys(goals, ACCEPTED_S) if before else {}
    seen = SeenContest('a2', Contest(goals=goals), '/arm_2', known)
    world.gateway._clients['a2']._news.add(seen)


def reasons(orchestrator: Orchestrator) -> list[str]:
    return [hold.reason for hold in orchestrator.state.holds.values()]


def test_9_2_goal_unknown_to_journal_raises_hold() -> None:
    """As after a journal was lost: this one is empty."""
    line = Line()
    world = World(line.cell)
    orchestrator = world.orchestrator()
    find(world, STRANGE)
    orchestrator.settle()
    (hold,) = orchestrator.state.holds.values()
    assert hold.reason == 'unknown_goal'
    assert hold.message.startswith(
        f'/a2/do at /arm_2 runs goal {STRANGE}, accepted 2023-11-14 22:13:20 UTC by its clock'
    )
    assert orchestrator.ask(AddJobs((Job('J', line.script(THREE), 1),))).accepted
    world.go(orchestrator)
    assert not world.events(e.TaskStarted), 'it is released only by naming it, auto_resume or not'

    find(world)
    orchestrator.settle()
    assert reasons(orchestrator) == ['unknown_goal'], 'its end says nothing of what it did'
    assert not orchestrator.ask(Resume(ann('go'), everyones=True)).accepted
    assert orchestrator.ask(Resume(ann('compared'), hold.id)).accepted
    world.go(orchestrator)
    assert orchestrator.state.ended['J'].progress.packed == 1


def test_9_2_released_cell_waits_for_running_goal() -> None:
    line = Line()
    world = World(line.cell)
    orchestrator = begun(world, line.script(THREE), 1)
    find(world, STRANGE)
    orchestrator.settle()
    assert orchestrator.ask(Resume(ann('compared'), '1')).accepted
    world.go(orchestrator)
    assert [event.task for event in world.events(e.TaskStarted)] == ['place', 'index']  # type: ignore[attr-defined]
    find(world)
    world.go(orchestrator)
    assert orchestrator.state.ended['J'].progress.packed == 1


def test_9_2_each_goal_raises_one_hold_over_restarts() -> None:
    world = World(Line().cell)
    first = world.orchestrator()
    find(world, STRANGE)
    first.settle()
    find(world, STRANGE)
    first.settle()
    assert reasons(first) == ['unknown_goal']
    first.close()
    second = world.orchestrator()
    find(world, STRANGE)
    second.settle()
    assert reasons(second) == ['unknown_goal']


def test_9_2_goals_of_tasks_that_go_on_are_known() -> None:
    line = Line()
    world = World(line.cell)
    first = killed_at_work(world, line.script(THREE), 1)
    (goal,) = [task.goal for task in first.state.running.values()]
    assert goal is not None
    second = world.orchestrator()
    find(world, goal)
    world.go(second)
    assert not world.events(e.ComponentContested)
    assert second.state.ended['J'].progress.packed == 1


def test_2_5_new_foreign_goal_is_awaited_without_hold() -> None:
    world = World(Line().cell)
    orchestrator = world.orchestrator()
    find(world, STRANGE, before=False)
    orchestrator.settle()
    assert reasons(orchestrator) == []
    assert orchestrator.state.contests == {'a2': Contest(goals=(STRANGE,))}


# --- what may be sent again waits for whoever looks ------------------------------------------

REPEATABLE = with_section(2, '- {id: work, @a2.TASK_B, repeatable: true}')


def restarted(text: str, unsent: str | None = None) -> tuple[World, Orchestrator]:
    """Kill an orchestrator at its task `work`, whose server forgets, and start the next one."""
    line = Line()
    world = World(line.cell)
    first = begun(world, line.script(text), 1)
    world.gateway.unsent = unsent
    if unsent:
        world.go_until_starts(first, 'work')
    else:
        world.go_until_runs(first, 'work')
    first.close()
    world.gateway.unsent = None
    client = world.gateway._clients['a2']
    client._remembered.clear()
    client._controller._stop_work()
    return world, world.orchestrator(auto_resume=False)


@pytest.mark.parametrize(
    ('text', 'unsent'),
    [(REPEATABLE, None), (with_section(2, '- {id: work, @a2.TASK_B}'), 'TASK_B')],
)
def test_9_2_goals_are_resent_only_after_restart_check(text: str, unsent: str | None) -> None:
    world, second = restarted(text, unsent)
    world.go(second)
    assert not world.events(e.TaskResent)
    assert reasons(second) == ['restarted']
    assert second.ask(Resume(ann('looked'), '1')).accepted
    world.go(second)
    assert len(world.events(e.TaskResent)) == 1
    assert second.state.ended['J'].progress.packed == 1


def test_9_2_nor_before_a_pause_is_over() -> None:
    world, second = restarted(REPEATABLE)
    assert second.ask(Pause(ann('a visitor'))).accepted
    assert second.ask(Resume(ann('looked'), '1')).accepted
    world.go(second)
    assert not world.events(e.TaskResent)
    assert second.ask(Resume(ann('gone'))).accepted
    world.go(second)
    assert second.state.ended['J'].progress.packed == 1


def test_9_2_cancelled_goal_awaiting_resend_is_in_doubt() -> None:
    world, second = restarted(REPEATABLE)
    world.go(second, 20)
    assert second.ask(Abort(ann('no'))).accepted
    second.settle()
    assert not second.state.running
    assert not world.events(e.TaskResent)
    assert [event.reason for event in world.events(e.TaskFailed)] == ['in_doubt']  # type: ignore[attr-defined]
