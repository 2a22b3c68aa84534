"""Semantics 7.3: pauses have owners, stack, and are released one by one."""

from __future__ import annotations

import pytest
from fakes.commands import AnswerHold, Pause, Resume
from fakes.line import THREE, Line
from fakes.operator import ann
from fakes.virtual_run import VirtualRun

from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.model import events as e
from bt_orchestrator.model.commands import FoundTwin
from bt_orchestrator.sim.gateway import VirtualClock, VirtualGateway
from bt_orchestrator.store.memory import MemoryStore


def paused(*who: str) -> VirtualRun:
    run = Line().begin(quantity=2).go(until=3.5)
    for name in who:
        assert run.command(Pause, who=name).accepted
    return run.go()


def test_7_3_two_pauses_need_two_resumes() -> None:
    run = paused('Ann', 'Bob')
    answer = run.command(Resume, who='Ann')
    assert answer.accepted
    assert answer.message == 'still paused: hold 2 (paused, Bob: it is so)'
    run.go()
    assert run.state.packml.value == 'Held'
    assert run.command(Resume, who='Bob').message == 'the cell goes on'
    run.go()
    assert run.ended


def test_7_3_nobody_resumes_for_others_by_mistake() -> None:
    run = paused('Ann')
    answer = run.command(Resume, who='Bob')
    assert not answer.accepted
    assert answer.message == (
        'no pause is yours; hold 1 (paused, Ann: it is so); the person who paused '
        'resumes, or name the hold to release it for that person'
    )
    assert list(run.state.holds) == ['1']


def test_7_3_a_pause_can_be_named() -> None:
    run = paused('Ann', 'Bob')
    wrong = run.command(Resume, who='Cat', hold='7')
    assert wrong.message == (
        'there is no pause 7; hold 1 (paused, Ann: it is so); hold 2 (paused, Bob: it is so)'
    )
    assert run.command(Resume, who='Cat', hold='2').accepted
    assert list(run.state.holds) == ['1']


def test_7_3_all_pauses_can_be_released_at_once() -> None:
    run = paused('Ann', 'Bob', 'Ann')
    assert run.command(Resume, who='Cat', everyones=True).accepted
    run.go()
    assert run.ended


def test_7_3_all_pauses_of_one_owner_are_released_together() -> None:
    run = paused('Ann', 'Ann')
    assert run.command(Resume, who='Ann').accepted
    assert not run.state.holds


def test_7_3_pause_before_order_prevents_work() -> None:
    line = Line()
    run = VirtualRun(line.cell, line.types)
    run.command(Pause)
    run.submit('J', line.script(THREE))
    run.go()
    assert run.state.packml.value == 'Held'
    assert run.all('task.started') == []
    run.command(Resume)
    run.go()
    assert run.ended


def test_7_3_a_pause_releases_nothing_that_is_held() -> None:
    run = Line(faults={'a2': '#1=abort'}).run()
    run.command(Pause)
    assert run.command(Resume).message == 'no longer paused; it waits for answers to hold 1'


# --- holds that must be named -----------------------------------------------------------------

NAMED = ('restarted', 'restored', 'twin')


def held_by(*reasons: str) -> Orchestrator:
    """Return an orchestrator whose journal ends with holds of the whole cell, numbered from 1."""
    line, clock, store = Line(), VirtualClock(), MemoryStore()
    store.append(
        [
            e.HoldRaised(seq=n, hold=str(n), reason=why, message='look', answers=('resume',))
            for n, why in enumerate(reasons, 1)
        ]
    )
    return Orchestrator(line.cell, VirtualGateway(line.cell, line.types, clock), clock, store)


@pytest.mark.parametrize('everyones', [False, True])
@pytest.mark.parametrize('reason', NAMED)
def test_7_3_look_hold_is_released_only_by_number(reason: str, everyones: bool) -> None:
    cell = held_by(reason)
    answer = cell.ask(Resume(ann('a visitor left'), everyones=everyones))
    assert not answer.accepted
    assert answer.message == (
        f'nothing was released; hold 1 ({reason}, look), which only its number releases: '
        'bt-orchestrator cell resume --hold 1 --reason WHY'
    )
    assert list(cell.state.holds) == ['1']
    assert cell.ask(Resume(ann('looked'), hold='1')).accepted
    assert not cell.state.holds


@pytest.mark.parametrize('everyones', [False, True])
def test_7_3_resume_reports_remaining_hold_and_its_release(everyones: bool) -> None:
    cell = held_by('restarted')
    assert cell.ask(Pause(ann('a visitor'))).accepted
    answer = cell.ask(Resume(ann('gone'), everyones=everyones))
    assert answer.accepted
    assert answer.message == (
        'still paused: hold 1 (restarted, look), which only its number releases: '
        'bt-orchestrator cell resume --hold 1 --reason WHY'
    )
    assert list(cell.state.holds) == ['1']


def test_7_3_named_holds_are_released_one_by_one() -> None:
    cell = held_by(*NAMED)
    for left in (2, 1, 0):
        assert cell.ask(Resume(ann('looked'), hold=next(iter(cell.state.holds)))).accepted
        assert len(cell.state.holds) == left


def test_7_3_node_with_twin_finishes_tasks_and_starts_none() -> None:
    run = Line().begin(quantity=3).go(until=3.5)
    for _ in range(2):
        assert run.ask(FoundTwin('process 7 on host x')).accepted
    (hold,) = run.state.holds.values()
    assert (hold.reason, hold.message) == ('twin', 'process 7 on host x')
    running = {key.task for key in run.state.running}
    assert running
    started = len(run.all('task.started'))
    run.go()
    assert run.state.packml.value == 'Held'
    assert len(run.all('task.started')) == started
    assert not run.all('task.cancel_requested')
    assert running <= set(run.order('task.succeeded'))
    run.command(Resume, hold=hold.id)
    run.go()
    assert run.ended


def test_7_3_answer_to_pause_explains_release() -> None:
    answer = held_by('twin').ask(AnswerHold('1', 'retry', ann()))
    assert answer.message == (
        'hold 1 (twin, look) takes no answer; bt-orchestrator cell resume --hold 1 --reason WHY'
    )
