"""Commands: orders, refusals, shutdown."""

from __future__ import annotations

from fakes.commands import Abort, Resume
from fakes.line import THREE, Line, with_section
from fakes.operator import ann

from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.model.commands import Shutdown
from bt_orchestrator.sim.gateway import VirtualClock, VirtualGateway
from bt_orchestrator.sim.simulation import Outcome, Simulation
from bt_orchestrator.store.memory import MemoryStore


def test_duplicate_order_is_refused_live_and_ended() -> None:
    line = Line()
    run = line.begin()
    for _ in range(2):
        events = len(run.records)
        answer = run.submit('J', line.script(THREE))
        assert not answer.accepted
        assert answer.message == 'order J was given before; choose another id'
        assert len(run.records) == events
        run.go()


def test_jobs_of_one_script_share_its_definition() -> None:
    line = Line()
    run = line.begin()
    run.submit('K', line.script(THREE))
    assert len(run.all('script.loaded')) == 1
    run.submit('L', line.script(with_section(2, '- {id: other, @a2}')))
    assert len(run.all('script.loaded')) == 2


def test_reason_with_control_characters_is_refused_and_marked() -> None:
    run = Line().begin()
    answer = run.ask(Resume(ann(reason='all \u202eorre is')))
    assert not answer.accepted
    assert answer.message == (
        'reason cannot be recorded: it has U+202E (RIGHT-TO-LEFT OVERRIDE), which hides or turns '
        'what is read; write it without; nothing was done'
    )
    assert run.order('operator.refused', 'reason') == ['all \ufffdorre is']


def test_invalid_reason_does_not_block_abort() -> None:
    run = Line().begin()
    assert run.ask(Abort(ann(reason='\x1b[31mfire'))).accepted
    assert run.order('operator.decided', 'reason') == ['\ufffd[31mfire']


def test_an_order_starts_the_cell_by_itself() -> None:
    run = Line().begin()
    states = [record['state'] for record in run.all('cell.state_changed')]
    assert states == ['Resetting', 'Idle', 'Starting', 'Execute']


def test_without_auto_start_an_order_waits() -> None:
    line = Line()
    clock, store = VirtualClock(), MemoryStore()
    gateway = VirtualGateway(line.cell, line.types, clock)
    orchestrator = Orchestrator(line.cell, gateway, clock, store, auto_start=False)
    orchestrator.settle()
    assert orchestrator.state.packml.value == 'Stopped'
    orchestrator.close()


def test_shutdown_cancels_every_goal_and_holds_its_task() -> None:
    run = Line(seconds={'a2': 9.0}).begin(
        with_section(2, '- {id: work, @a2, retries: 5, on_failure: continue}'), 2
    )
    run.go(until=3.5)
    assert run.ask(Shutdown()).message == '2 goals are being cancelled'
    assert run.order('task.cancel_requested', 'cause') == ['shutdown', 'shutdown']
    run.go(until=3.5)
    assert run.reasons() == ['canceled', 'canceled']
    assert run.all('task.retrying') == []
    assert sorted(run.order('hold.raised')) == ['place', 'work']
    assert run.state.packml.value == 'Stopped'
    assert run.state.items.keys() == {'J/1', 'J/2'}


def test_shutdown_starts_nothing_more() -> None:
    run = Line().begin(quantity=9).go(until=4.0)
    run.ask(Shutdown())
    started = len(run.all('task.started'))
    run.go()
    assert len(run.all('task.started')) == started


def test_shutdown_during_retry_delay_starts_nothing() -> None:
    line = Line(faults={'a2': '#1=abort'})
    run = line.begin(with_section(2, '- {id: work, @a2, retries: 1, retry_delay: 5}'))
    run.go(until=4.0)
    run.ask(Shutdown())
    run.go()
    assert run.state.packml.value == 'Stopped'
    assert run.starts('work') == [3.0]
    run.submit('K', line.script(THREE))
    run.go()
    assert run.state.packml.value == 'Stopped'
    assert run.starts('work') == [3.0]


def test_new_orchestrator_resumes_work_after_shutdown() -> None:
    line = Line(faults={'a2': '#1=abort'})
    run = line.begin(with_section(2, '- {id: work, @a2, retries: 2, retry_delay: 5}'))
    run.go(until=4.0)
    run.ask(Shutdown())
    run.sim.close()
    again = Simulation(line.cell, line.types, run.store)  # its faults strike anew
    assert again.run() is Outcome.HELD
    assert again.orchestrator.ask(Resume(ann('all is well'), hold='1')).accepted
    assert again.run() is Outcome.FINISHED
    assert again.state.ended['J'].progress.packed == 1
