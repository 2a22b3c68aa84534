"""Semantics 7.9: goals start only while the safety input is ready, and one loss ends them once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import pytest
from fakes.commands import Clear, Reset, Resume, SetService, Start
from fakes.line import THREE, Line
from fakes.operator import ann
from fakes.virtual_run import VirtualRun
from fakes.world import World, killed_at_work

from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import Cell, SafetyInput
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.judging.belt_statement import AsShown
from bt_orchestrator.model.requests import REQUESTS

LINE = Line()
SCRIPT = LINE.script(THREE)
TOPIC = SafetyInput('/safety/ok', 'std_msgs/msg/Bool', 'data', (True,))


def safe_cell(line: Line = LINE) -> Cell:
    return replace(line.cell, safety=TOPIC)


def at_work(until: float = 4.0) -> VirtualRun:
    run = VirtualRun(safe_cell(), LINE.types)
    run.submit('J', SCRIPT, 3)
    run.go(until)
    assert run.state.running
    return run


def say(run: VirtualRun, unsafe: str) -> None:
    run.sim.gateway.say_of_safety(unsafe)
    run.sim.orchestrator.settle()


def aborts(run: VirtualRun) -> list[Any]:
    return [change for change in run.all('cell.state_changed') if change['state'] == 'Aborting']


def test_7_9_cell_without_safety_input_is_unchanged() -> None:
    assert digest(LINE.cell) != digest(safe_cell())
    run = Line().run()
    assert run.all('safety.changed') == []


def test_7_9_flapping_loss_cancels_every_goal_once() -> None:
    run = at_work()
    running = set(run.state.running)
    say(run, 'no message for 0.5 s')
    assert run.state.packml.value in ('Aborting', 'Aborted')
    for unsafe in ('', 'its value is False', '', 'it has no publisher'):
        say(run, unsafe)
    run.go()
    assert run.state.packml.value == 'Aborted'
    assert run.state.stop_reason is not None
    assert run.state.stop_reason.value == 'emergency'
    assert len(aborts(run)) == 1
    assert not [row for row in run.all('hold.raised') if row['reason'] == 'safety']
    assert {row['task'] for row in run.all('task.cancel_requested')} == {k.task for k in running}
    assert aborts(run)[0]['reason'] == 'the safety input is not ready: no message for 0.5 s'
    reasons = [run.state.tasks[key].reason for key in running]
    assert all(reason is not None and reason.value == 'in_doubt' for reason in reasons)


def test_7_9_loss_without_goal_raises_hold_not_abort() -> None:
    run = VirtualRun(safe_cell(), LINE.types)
    run.go()
    for unsafe in ('its value is False', '', 'it is False'):
        say(run, unsafe)
    (hold,) = run.all('hold.raised')
    assert (hold['reason'], hold['message']) == (
        'safety',
        'the safety input is not ready: its value is False',
    )
    assert aborts(run) == []


def test_7_9_return_starts_nothing_before_hold_is_released() -> None:
    run = VirtualRun(safe_cell(), LINE.types)
    run.go()
    say(run, 'its value is False')
    run.submit('J', SCRIPT, 1)
    refused = run.ask(Resume(ann(), '1'))
    assert refused.message == (
        'cell.resume is refused: the safety input is not ready: its value is False'
    )
    say(run, '')
    run.go()
    assert run.all('task.started') == []
    assert 'hold 1' in run.ask(Resume(ann())).message
    assert run.ask(Resume(ann(), '1')).accepted
    run.go()
    assert run.job().exit_status == 'completed'


def test_7_9_after_an_abort_its_return_starts_nothing() -> None:
    run = at_work()
    say(run, 'its value is False')
    run.go()
    clear = Clear(ann(), AsShown(run.state.seq))
    assert 'cell.clear is refused' in run.ask(clear).message
    say(run, '')
    run.go()
    assert run.state.packml.value == 'Aborted'
    before = len(run.all('task.started'))
    for hold in list(run.state.holds):
        run.answer(run.state.holds[hold].answers[0], hold)
    assert run.ask(Clear(ann(), AsShown(run.state.seq))).accepted
    run.go()
    assert run.state.packml.value == 'Stopped'
    assert len(run.all('task.started')) == before
    assert run.ask(Reset(ann())).accepted
    run.go()
    assert run.ask(Start(ann())).accepted


def test_7_9_starting_requests_are_refused_while_not_ready() -> None:
    needing = {name for name, request in REQUESTS.items() if request.needs_safety}
    assert needing == {
        *('cell.reset', 'cell.start', 'cell.resume', 'cell.clear', 'component.in_service'),
        *('cell.manual', 'component.run_task'),
    }
    run = VirtualRun(safe_cell(), LINE.types)
    run.go()
    assert run.ask(SetService('a2', False, ann())).accepted
    say(run, 'its value is False')
    for asked in (Reset(ann()), Start(ann()), SetService('a2', True, ann())):
        answer = run.ask(asked)
        assert not answer.accepted
        assert 'the safety input is not ready: its value is False' in answer.message
        assert run.all('operator.refused')[-1]['message'] == answer.message


def test_7_9_nothing_starts_before_it_was_heard() -> None:
    run = VirtualRun(safe_cell(), LINE.types)
    run.sim.gateway.drain()  # nobody publishes it
    run.sim.gateway.unsafe = 'nothing was heard of it yet'
    run.submit('J', SCRIPT, 1)
    run.go()
    assert run.state.packml.value == 'Stopped'
    assert run.all('task.started') == run.all('hold.raised') == []
    say(run, 'it has no publisher')
    assert [record['reason'] for record in run.all('hold.raised')] == ['safety']


@pytest.mark.parametrize('unsafe', ['', 'its value is False'])
def test_7_9_take_over_ends_goals_unless_input_is_ready(unsafe: str) -> None:
    world = World(safe_cell())
    killed_at_work(world, SCRIPT)
    world.gateway.unsafe = unsafe
    second = world.orchestrator(auto_resume=True)
    assert second.state.running
    assert second.state.unsafe == 'nothing was heard of it yet'
    world.go(second)
    changes = [event for event in world.store.read() if isinstance(event, e.CellStateChanged)]
    assert [event.state for event in changes].count('Aborting') == (1 if unsafe else 0)
    if unsafe:
        assert second.state.packml.value == 'Aborted'
    else:
        assert not second.state.jobs


def test_7_9_loss_during_record_write_prevents_sending() -> None:
    run = VirtualRun(safe_cell(), LINE.types)
    gateway = run.sim.gateway
    sent: list[str] = []
    send = gateway.send

    def watched(request: Any) -> Any:
        sent.append(request.task)
        return send(request)

    gateway.send = watched  # type: ignore[method-assign]
    append = run.store.append

    def appending(events: Sequence[e.Event]) -> None:
        append(events)
        if any(isinstance(event, e.TaskStarted) for event in events):
            gateway.say_of_safety('its value is False')  # while the record is written

    run.store.append = appending  # type: ignore[method-assign]
    run.submit('J', SCRIPT, 1)
    run.go()
    (started,) = run.all('task.started')
    assert sent == []
    assert run.state.packml.value == 'Aborted'
    (failed,) = run.all('task.failed')
    assert (failed['goal'], failed['reason']) == (started['goal'], 'in_doubt')
    assert failed['message'] == 'it was not sent: the safety input is not ready'
    assert failed['never_begun'] is True
