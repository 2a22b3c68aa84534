"""Semantics 7.2: the states of the cell, the table of their transitions, and the commands."""

from __future__ import annotations

import pytest
from fakes.commands import (
    Abort,
    AnswerHold,
    CellCommand,
    Clear,
    Pause,
    Reset,
    Resume,
    Start,
    Stop,
    StopAfter,
)
from fakes.line import THREE, Line, with_section
from fakes.operator import ann
from fakes.virtual_run import BY, VirtualRun

from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.model import events as e
from bt_orchestrator.model.commands import Shutdown
from bt_orchestrator.model.fold import apply
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.judging.belt_statement import AsShown
from bt_orchestrator.model.packml import TRANSITIONS, PackmlState
from bt_orchestrator.sim.gateway import VirtualClock, VirtualGateway
from bt_orchestrator.sim.simulation import Simulation
from bt_orchestrator.store.memory import MemoryStore

# --- the table --------------------------------------------------------------------------------

NEVER_STOPPED = {'Stopping', 'Stopped', 'Aborting', 'Aborted', 'Clearing'}
ARROWS = """
Stopped reset Resetting done Idle start Starting done Execute done Completing done Complete
Complete reset Resetting
Execute hold Holding done Held unhold Unholding done Execute
Execute suspend Suspending done Suspended unsuspend Unsuspending done Execute
Starting hold Holding
Suspending hold Holding
Suspended hold Holding
Unsuspending hold Holding
Unholding hold Holding
Stopping done Stopped
Aborting done Aborted clear Clearing done Stopped
"""
"""Rule 7.2 as it is written, for a second time; stop and abort are checked by their words."""


def arrows() -> set[tuple[str, str, str]]:
    transitions = set()
    for line in ARROWS.strip().splitlines():
        words = line.split()
        transitions |= {tuple(words[n : n + 3]) for n in range(0, len(words) - 2, 2)}
    states = {packml.value for packml in PackmlState}
    transitions |= {(state, 'stop', 'Stopping') for state in states - NEVER_STOPPED}
    transitions |= {(state, 'abort', 'Aborting') for state in states - {'Aborting', 'Aborted'}}
    return transitions  # type: ignore[return-value]


def test_7_2_the_table_is_the_rule() -> None:
    table = {
        (packml.value, cause.value, after.value)
        for packml, row in TRANSITIONS.items()
        for cause, after in row.items()
    }
    assert table == arrows()
    assert len(PackmlState) == 17


COMMANDS: dict[str, CellCommand] = {
    'reset': Reset,
    'start': Start,
    'stop': Stop,
    'abort': Abort,
    'clear': Clear,
}


def orchestrator_in(packml: PackmlState) -> Orchestrator:
    """Return an orchestrator whose journal ended in a state; it has not settled yet."""
    line, clock, store = Line(), VirtualClock(), MemoryStore()
    event = e.CellStateChanged(seq=1, state=packml.value, previous='Stopped')
    store.append([event])
    gateway = VirtualGateway(line.cell, line.types, clock)
    return Orchestrator(line.cell, gateway, clock, store, auto_start=False)


@pytest.mark.parametrize('verb', COMMANDS)
@pytest.mark.parametrize('packml', PackmlState)
def test_7_2_every_command_in_every_state(packml: PackmlState, verb: str) -> None:
    orchestrator = orchestrator_in(packml)
    kind = COMMANDS[verb]
    seen = AsShown(orchestrator.state.seq)
    command = Clear(ann('so'), belt=seen) if kind is Clear else kind(ann('so'))
    before = orchestrator.state.seq
    answer = orchestrator.ask(command)
    orchestrator.settle()
    events = [event for event in orchestrator._store.read() if event.seq > before]

    after = {arrow[2] for arrow in arrows() if arrow[:2] == (packml.value, verb)}
    assert answer.accepted is bool(after)
    if after:
        changed = next(event for event in events if isinstance(event, e.CellStateChanged))
        assert {changed.state} == after
        assert (changed.previous, changed.cause) == (packml.value, verb)
        assert any(isinstance(event, e.OperatorDecided) for event in events)
        return
    (refused,) = [event for event in events if isinstance(event, e.OperatorRefused)]
    assert (refused.command, refused.who, refused.message) == (verb, 'Ann', answer.message)
    assert answer.message.startswith(f'the cell is {packml.value}; {verb} is for ')
    possible = answer.message.partition('possible now: ')[2].split(', ')
    named = {cause for before, cause, _ in arrows() if before == packml.value} & {*COMMANDS}
    assert set(possible) == named | {'pause', 'resume'}


def table_walk(orchestrator: Orchestrator) -> list[str]:
    events = orchestrator._store.read()
    return [event.state for event in events if isinstance(event, e.CellStateChanged)]


@pytest.mark.parametrize('packml', PackmlState)
def test_7_2_pause_and_resume_in_every_state(packml: PackmlState) -> None:
    orchestrator = orchestrator_in(packml)
    assert orchestrator.ask(Pause(ann('a visitor'))).accepted
    (hold,) = orchestrator.state.holds.values()
    assert (hold.owner, hold.reason, hold.message) == ('Ann', 'paused', 'Ann: a visitor')
    holds = (packml.value, 'hold', 'Holding') in arrows()
    assert ('Holding' in table_walk(orchestrator)[1:]) is holds
    assert orchestrator.ask(Resume(ann('gone'))).accepted
    assert not orchestrator.state.holds


# --- reset and start --------------------------------------------------------------------------


def test_7_2_cell_without_auto_start_needs_reset_and_start() -> None:
    run = Line().begin(auto_start=False)
    run.go()
    assert run.states == []
    assert run.command(Start).message == (
        'the cell is Stopped; start is for Idle; possible now: reset, pause, resume, abort'
    )
    assert run.command(Reset).accepted
    assert run.states == ['Resetting', 'Idle']
    assert run.command(Start).accepted
    run.go()
    assert run.ended
    assert run.states[2:] == ['Starting', 'Execute', 'Completing', 'Complete']


def test_7_2_started_cell_waits_for_first_order() -> None:
    line = Line()
    run = VirtualRun(line.cell, line.types, auto_start=False)
    run.command(Reset)
    run.command(Start)
    assert run.state.packml.value == 'Execute'
    run.submit('J', line.script(THREE))
    run.go()
    assert run.ended
    assert run.state.packml.value == 'Complete'


def test_7_2_auto_start_restarts_complete_cell_for_order() -> None:
    for auto_start, ended in ((True, True), (False, False)):
        line = Line()
        run = VirtualRun(line.cell, line.types, auto_start=auto_start)
        run.command(Reset)
        run.command(Start)
        run.submit('J', line.script(THREE))
        run.go()
        run.submit('K', line.script(THREE))
        run.go()
        assert run.ended is ended


# --- stop -------------------------------------------------------------------------------------

TWO_STEPS = with_section(2, '[{id: work, @a2}, {id: more, @b2}]')


def stopped(**options: object) -> VirtualRun:
    """Run until section 2 works on item 1 and section 1 has placed item 2, and stop."""
    run = Line(seconds={'a2': 3.0}).begin(TWO_STEPS, 4, **options).go(until=4.0)  # type: ignore[arg-type]
    assert run.command(Stop).accepted
    return run


def test_7_2_stop_finishes_cycles_and_begins_none() -> None:
    run = stopped()
    assert run.state.packml.value == 'Stopping'
    begun = len(run.all('cycle.started'))
    run.go()
    assert run.state.packml.value == 'Stopped'
    assert run.starts('more') == [6.0]
    assert run.times('cell.state_changed', state='Stopped') == [7.0]
    assert len(run.all('cycle.started')) == begun
    assert run.all('task.cancel_requested') == []
    assert run.state.sections[2].cycle is None


def test_7_2_stopped_work_continues_after_reset_and_start() -> None:
    run = stopped()
    run.go()
    assert run.command(Reset).accepted
    run.go()
    assert run.state.packml.value == 'Idle', 'the jobs that were there are no reason to start'
    assert run.command(Start).accepted
    run.go()
    assert run.counts()['packed'] == 4


def test_7_2_no_order_starts_what_an_operator_stopped() -> None:
    run = stopped()
    script = Line().script(THREE, 'other')
    for job, packml in (('K', 'Stopped'), ('L', 'Stopped')):
        answer = run.submit(job, script)
        assert answer.message == (
            f'{job} is queued\nthe cell waits for reset and start, for Ann said stop: it is so'
        )
        assert run.go().state.packml.value == packml
    assert run.command(Reset).accepted
    assert run.submit('M', script).message.endswith('waits for start, for Ann said stop: it is so')
    assert run.go().state.packml.value == 'Idle', 'a reset is no start'
    assert run.command(Start).accepted
    assert run.submit('N', script).message == 'N is queued'
    run.go()
    assert run.ended


def test_7_2_order_does_not_start_cleared_cell() -> None:
    run = Line().run()
    script = Line().script(THREE, 'other')
    run.command(Abort)
    assert 'waits for clear, reset and start' in run.submit('K', script).message
    run.command(Clear, belt=AsShown(run.state.seq))
    assert 'for Ann said clear' in run.submit('L', script).message
    assert run.go().state.packml.value == 'Stopped'
    run.command(Reset)
    run.command(Start)
    run.go()
    assert run.ended


def test_7_2_order_does_not_start_cell_stopped_after_job() -> None:
    run = Line().begin(TWO_STEPS, 2).go(until=2.0)
    script = Line().script(THREE, 'other')
    run.ask(StopAfter('job', BY))
    answer = run.submit('K', script)
    assert answer.message.endswith(
        'when it has stopped, the cell waits for reset and start, '
        'for Ann said stop after job: it was time'
    )
    run.go()
    assert run.state.packml.value == 'Stopped'
    run.submit('L', script)
    assert run.go().state.packml.value == 'Stopped'
    run.command(Reset)
    run.command(Start)
    run.go()
    assert run.ended


def test_7_2_revoked_stop_after_lets_orders_start() -> None:
    run = Line().begin(TWO_STEPS, 2).go(until=2.0)
    run.ask(StopAfter('job', BY))
    run.ask(StopAfter('never', BY))
    assert run.submit('K', Line().script(THREE, 'other')).message == 'K is queued'
    run.go()
    assert run.ended


def test_7_2_revoking_stop_after_keeps_a_stop() -> None:
    run = stopped()
    run.ask(StopAfter('job', BY))
    run.ask(StopAfter('never', BY))
    run.submit('K', Line().script(THREE, 'other'))
    assert run.go().state.packml.value == 'Stopped'


def test_7_2_release_answer_says_cell_waits() -> None:
    run = stopped()
    run.add(('K', Line().script(THREE, 'other')), held=True)
    assert run.control('release', 'K').message == (
        'K is released\nthe cell waits for reset and start, for Ann said stop: it is so'
    )
    assert run.go().state.packml.value == 'Stopped'


@pytest.mark.parametrize('reset', [False, True])
@pytest.mark.parametrize('how', ['stop', 'stop_after', 'stop_after_not_reached'])
def test_7_2_new_orchestrator_keeps_cell_stopped_by_operator(how: str, reset: bool) -> None:
    line = Line()
    run = line.begin(TWO_STEPS, 4).go(until=4.0)
    if how == 'stop':
        run.command(Stop)
    else:
        run.ask(StopAfter('item', BY))
    if how == 'stop_after_not_reached':
        run.ask(Shutdown())
    run.go()
    for _ in range(reset):
        run.command(Reset)
    run.sim.close()
    again = Simulation(line.cell, line.types, run.store)
    again.run()
    for hold in list(again.state.holds):
        again.orchestrator.ask(AnswerHold(hold, 'retry', ann()))
    again.submit([Job('K', line.script(THREE, 'other'), 1)])
    again.run()
    assert again.state.packml.value == ('Idle' if reset else 'Stopped')
    assert not [x for x in run.store.read() if isinstance(x, e.TaskStarted) and x.job == 'K']
    if not reset:
        assert again.orchestrator.ask(Reset(ann())).accepted
    assert again.orchestrator.ask(Start(ann())).message == 'the cell starts'
    assert again.state.stopped_by is None


def test_7_2_after_a_shutdown_the_next_orchestrator_goes_on() -> None:
    line = Line()
    run = line.begin(TWO_STEPS, 4).go(until=4.0)
    run.ask(Shutdown())
    run.go()
    run.sim.close()
    again = Simulation(line.cell, line.types, run.store)
    again.orchestrator.ask(Resume(ann(), hold=list(again.state.holds)[-1]))
    for hold in list(again.state.holds):
        again.orchestrator.ask(AnswerHold(hold, 'mark_done', ann()))
    again.run()
    assert not again.state.jobs


def test_7_2_stop_waits_for_briefly_busy_component() -> None:
    line = Line(topics=('b2',), faults={'b2': '#0=not_ready:9'})
    run = line.begin(TWO_STEPS, 3).go(until=3.5)
    run.command(Stop)
    run.go()
    assert run.starts('more') == [9.0]
    assert run.times('cell.state_changed', state='Stopped') == [10.0]


def test_7_2_stop_leaves_held_tasks_held() -> None:
    run = Line(faults={'a2': '#1=abort'}).run(TWO_STEPS, 2)
    assert run.state.packml.value == 'Held'
    run.command(Stop)
    assert run.state.packml.value == 'Stopped'
    run.answer('retry')
    run.go()
    assert run.starts('work') == [3.0], 'an answer starts nothing in Stopped'
    run.command(Reset)
    run.command(Start)
    run.go()
    assert run.ended


# --- abort ------------------------------------------------------------------------------------


def aborted(at: float = 3.5, **faults: str) -> VirtualRun:
    line = Line(seconds={'a2': 3.0}, faults=faults)
    run = line.begin(TWO_STEPS, 3).go(until=at)
    assert run.command(Abort).accepted
    return run


def test_7_2_abort_cancels_every_goal_and_keeps_everything() -> None:
    run = aborted()
    assert run.state.packml.value == 'Aborting'
    assert sorted(run.order('task.cancel_requested')) == ['place', 'work']
    assert set(run.order('task.cancel_requested', 'cause')) == {'abort'}
    slots = {n: section.slot for n, section in run.state.sections.items()}
    run.go()
    assert run.state.packml.value == 'Aborted'
    assert {n: section.slot for n, section in run.state.sections.items()} == slots
    assert run.job().progress.started == 2
    assert not run.ended


def test_7_2_cancelled_tasks_are_in_doubt_under_any_policy() -> None:
    text = with_section(2, '- {id: work, @a2, retries: 3, on_failure: continue}')
    run = Line(seconds={'a2': 3.0}).begin(text, 3).go(until=3.5)
    run.command(Abort)
    run.go()
    held = {hold.task: hold.reason for hold in run.state.holds.values()}
    assert held == {'work': 'in_doubt', 'place': 'in_doubt'}
    assert run.all('task.retrying') == []
    assert set(run.state.reserved) == {'a1', 'a2'}, 'they may still be moving'


def test_7_2_aborted_is_reached_when_every_goal_has_ended() -> None:
    run = aborted(a2='#1=ignore_cancel')
    run.go(until=5.0)
    assert run.state.packml.value == 'Aborting'
    run.go()
    assert run.times('cell.state_changed', state='Aborted') == [8.0]  # after the grace


def test_7_2_nothing_starts_between_abort_and_start() -> None:
    run = aborted()
    run.go()
    for hold in list(run.state.holds):
        assert run.answer('retry', hold).accepted
    run.submit('K', Line().script(THREE, 'other'))
    run.go()
    started = len(run.all('task.started'))
    assert run.command(Clear, belt=AsShown(run.state.seq)).accepted
    run.go()
    assert run.state.packml.value == 'Stopped'
    run.command(Reset)
    run.go()
    assert len(run.all('task.started')) == started
    run.command(Start)
    run.go()
    assert run.ended
    assert run.counts()['packed'] == 3


def test_7_2_homing_is_done_again_after_an_abort() -> None:
    home = 'initialization: [{id: home, task: HOME, action: /belt/do, once: true}]\n'
    line = Line()
    run = line.run(home + THREE)
    run.command(Abort)
    run.command(Clear, belt=AsShown(run.state.seq))
    run.submit('K', line.script(home + THREE))
    run.command(Reset)
    run.command(Start)
    run.go()
    assert [r['job'] for r in run.all('task.started', task='home')] == ['J', 'K']


# --- time in states ---------------------------------------------------------------------------


def test_7_2_the_time_in_every_state_is_counted() -> None:
    run = Line(faults={'a2': '#1=abort'}, seconds={'a1': 5.0}).run(quantity=2)
    assert run.state.packml.value == 'Held'
    spent = {packml.value: s for packml, s in run.state.times(20.0).items() if s}
    assert spent == {'Execute': 8.0, 'Holding': 4.0, 'Held': 8.0}
    assert run.state.packml_since == 12.0


def test_7_2_time_without_an_orchestrator_counts_for_no_state() -> None:
    run = Line(faults={'a2': '#1=abort'}).run(quantity=1)
    state, at = run.state, run.now
    spent = state.times(at)
    again = e.OrchestratorStarted(seq=state.seq + 1, time=at + 1000.0, cell='c', digest='d')
    apply(state, again)
    assert state.times(at + 1001.0) == {**spent, PackmlState.HELD: spent[PackmlState.HELD] + 1.0}


def test_7_2_command_record_has_user_reason_and_origin() -> None:
    run = Line().begin(auto_start=False)
    run.command(Reset, who='Bob')
    (decided,) = run.all('operator.decided')
    assert {key: decided[key] for key in ('answer', 'who', 'reason', 'origin')} == {
        'answer': 'reset',
        'who': 'Bob',
        'reason': 'it is so',
        'origin': 'a test',
    }


def test_7_2_nothing_begins_before_the_cell_says_execute() -> None:
    """One instant: the answer completes the last turn, so the belt may move."""
    run = Line(faults={'a1': '#1=abort'}).run(THREE)
    seq = run.state.seq
    run.answer('mark_done')
    events = [r['event'] for r in run.records if r['seq'] > seq and r['time'] == run.now]
    states = [n for n, event in enumerate(events) if event == 'cell.state_changed']
    assert run.states[-1] == 'Execute'
    assert max(states) < events.index('belt.index_started')
