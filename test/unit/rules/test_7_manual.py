"""Semantics 7.11: in manual the cell stands, and an engineer at a panel runs single goals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import pytest
from fakes.commands import Abort, AnswerHold, Clear, Pause, Reset, Resume, SetService, Start, Stop
from fakes.line import THREE, TYPES, Line, with_initialization, with_section
from fakes.operator import ann, engineer
from fakes.request_bench import SETUPS, RequestBench
from fakes.virtual_run import VirtualRun
from fakes.world import World

from bt_orchestrator.base.errors import JournalFailed, JournalMismatch
from bt_orchestrator.base.replies import begin
from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.model import events as e
from bt_orchestrator.model.by import By, Known, Role
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.goal import Contest
from bt_orchestrator.model.jobs.job_commands import AddJobs
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.jobs.setups import known
from bt_orchestrator.model.judging.belt_statement import AsShown, Slots
from bt_orchestrator.model.packml import PackmlState, UnitMode
from bt_orchestrator.model.requests import RUN_TASK, UNIT_MODES, Asked, ask
from bt_orchestrator.sim.simulation import Simulation

EVE = By('Eve', 'panel 3', 'to look at the gripper', Role.ENGINEER, Known.PAGE_PANEL)
BEN = By('Ben', 'panel 4', 'his turn', Role.ENGINEER, Known.PAGE_PANEL)
LINE = Line(seconds={'a2': 10.0})


def enter(run: VirtualRun | Simulation | Orchestrator, by: By = EVE) -> None:
    engine = engine_of(run)
    assert engine.ask(ask('cell.local', by)).accepted
    answer = engine.ask(ask('cell.manual', by))
    assert answer.accepted, answer


def engine_of(run: VirtualRun | Simulation | Orchestrator) -> Orchestrator:
    if isinstance(run, VirtualRun):
        return run.sim.orchestrator
    return run.orchestrator if isinstance(run, Simulation) else run


def in_manual(cell: Cell = LINE.cell) -> VirtualRun:
    run = VirtualRun(cell, TYPES)
    enter(run)
    assert run.state.unit_mode is UnitMode.MANUAL
    return run


def send(
    run: VirtualRun | Orchestrator, component: str = 'a2', by: By = EVE, **more: Any
) -> Answer:
    given = {'task': 'TASK_A', 'component': component, **more}
    return engine_of(run).ask(Asked(RUN_TASK, by, given))


def leave(run: VirtualRun, **belt: Any) -> Answer:
    given = belt or {'belt': AsShown(run.state.seq)}
    return run.ask(Asked(UNIT_MODES[UnitMode.PRODUCTION], EVE, given))


def wait(run: VirtualRun, seconds: float, heard: By | None = EVE) -> None:
    """Let time pass, with a sign of life each half second."""
    clock, until = run.sim.clock, run.now + seconds
    while run.now < until:
        clock.call_at(min(run.now + 0.5, until), lambda: None)
        assert clock.advance()
        if heard is not None and run.state.unit_mode is UnitMode.MANUAL:
            assert run.sim.orchestrator.ask(ask('cell.at_panel', heard)).accepted
        run.sim.orchestrator.settle()
    run._check()


def ended(run: VirtualRun) -> str:
    """Return how the last goal ended."""
    goal = run.sim.status().manual
    assert goal is not None
    return goal.state


# --- entering -----------------------------------------------------------------------------------


def test_7_11_1_manual_is_for_a_line_in_local() -> None:
    run = VirtualRun(LINE.cell, TYPES)
    answer = run.ask(ask('cell.manual', EVE))
    assert answer.message == (
        'cell.manual is asked at a panel of a line in local, and the line is in remote; nothing '
        'was done; give control to the panels with local first'
    )
    assert run.ask(ask('cell.local', EVE)).accepted
    elsewhere = By('Eve', 'home', 'to look', Role.ENGINEER, Known.PAGE_LOGIN)
    assert 'only its panels' in run.ask(ask('cell.manual', elsewhere)).message
    operator = By('Bob', 'panel 3', 'to look', Role.OPERATE, Known.PAGE_PANEL)
    assert 'is for the role engineer' in run.ask(ask('cell.manual', operator)).message
    assert run.ask(ask('cell.manual', EVE)).accepted
    assert 'already' in run.ask(ask('cell.manual', EVE)).message
    (changed,) = run.all('cell.unit_mode_changed')
    assert (changed['mode'], changed['reason']) == ('manual', 'Eve: to look at the gripper')


def test_7_11_1_busy_or_loaded_cell_refuses_manual_mode() -> None:
    run = LINE.begin(THREE, 2)
    run.go(5.0)
    assert run.ask(ask('cell.local', EVE)).accepted
    assert run.ask(ask('cell.manual', EVE)).message == (
        'the cell is Execute; manual is for Stopped or Idle, where nothing runs; stop it first'
    )
    assert run.ask(Abort(ann())).accepted
    run.go()
    assert run.ask(Clear(ann(), AsShown(run.state.seq))).accepted
    run.go()
    assert run.state.packml is PackmlState.STOPPED
    message = run.ask(ask('cell.manual', EVE)).message
    assert message.startswith('there are items on the belt: 1=J/2,2=J/1,3=empty; take them off')
    for item in ('J/1', 'J/2'):
        assert run.remove(item).accepted
    assert run.ask(ask('cell.manual', EVE)).accepted


# --- nothing starts by itself -------------------------------------------------------------------


def test_7_11_2_manual_mode_starts_nothing_by_itself() -> None:
    run = in_manual()
    run.submit('J', LINE.script(THREE))
    run.go()
    assert run.state.packml is PackmlState.STOPPED
    for command in (Reset(EVE), ask('cell.remote', EVE)):
        message = run.ask(command).message
        assert message.endswith('the cell is in manual mode; end it with production first')
    status = run.sim.status()
    assert 'reset' not in status.commands
    assert status.waits_for == 'production, reset and start'
    assert run.all('task.started') == []


def test_7_11_2_from_idle_the_cell_stands_in_idle() -> None:
    run = VirtualRun(LINE.cell, TYPES)
    assert run.ask(Reset(ann())).accepted
    run.go()
    enter(run)
    run.submit('J', LINE.script(THREE))
    run.go()
    assert run.state.packml.value == 'Idle'
    assert 'is in manual mode' in run.ask(Start(EVE)).message
    assert send(run).accepted
    assert run.ask(Stop(ann())).accepted
    wait(run, 11.0)
    assert run.state.packml.value == 'Stopped'
    assert ended(run) == 'done'


def test_7_11_2_restart_in_manual_ignores_auto_resume() -> None:
    world = World(LINE.cell)
    first = world.orchestrator()
    enter(first)
    assert first.ask(AddJobs((Job('J', LINE.script(THREE), 1, {}),), EVE)).accepted
    first.close()
    second = world.orchestrator(auto_resume=True)
    world.go(second, 50)
    assert second.state.unit_mode is UnitMode.MANUAL
    assert second.state.packml is PackmlState.STOPPED
    assert [hold.reason for hold in second.state.holds.values()] == []
    second.close()
    third = world.orchestrator(auto_resume=False)
    assert third.state.holds == {}


def test_7_11_2_manual_mode_refuses_changed_cell_file() -> None:
    world = World(LINE.cell)
    first = world.orchestrator()
    enter(first)
    first.close()
    world.cell = Line(4).cell
    with pytest.raises(JournalMismatch, match='in manual mode and the cell file has changed'):
        world.orchestrator()


# --- a goal -------------------------------------------------------------------------------------


def test_7_11_3_goal_is_recorded_before_it_is_sent() -> None:
    line = Line(seconds={'a2': 10.0}, results={'a2': {'measurement': 2.5}})
    run = in_manual(line.cell)
    assert send(run, args={'special_argument_2': 1.5}).message == 'TASK_A is sent to a2'
    decided, asked, started = run.records[-3:]
    assert (decided['answer'], decided['component'], decided['who']) == ('run_task', 'a2', 'Eve')
    assert (asked['event'], asked['args']) == ('manual.asked', {'special_argument_2': 1.5})
    assert started['event'] == 'task.started'
    assert (started['task'], started['name'], started['component']) == ('manual', 'TASK_A', 'a2')
    assert 'job' not in started
    wait(run, 11.0)
    goal = run.sim.status().manual
    assert goal is not None
    assert (goal.state, goal.results['measurement'], goal.who) == ('done', 2.5, 'Eve')
    assert run.state.reserved == {}
    assert run.state.manual is not None
    assert send(run, 'lamp').accepted


def test_7_11_3_action_type_defines_tasks_and_arguments(tmp_path: Any) -> None:
    bench = RequestBench(tmp_path)
    enter(bench.sim)

    def asked(**given: object) -> str:
        asked = ask('component.run_task', EVE, **given)
        return begin(bench.handler.carry_out(asked)).value.message

    assert asked(component='a9', task='TASK_A').startswith(
        "there is no component 'a9'; the cell has"
    )
    assert asked(component='a2', task='TASK_D') == (
        'bt_orchestrator_interfaces/action/Component has no task `TASK_D`; did you mean `TASK_C`?'
    )
    assert asked(component='a2', task='TASK_A', args={'task': 1}) == (
        'args: the goal of bt_orchestrator_interfaces/action/Component has no field `task`; its '
        'fields are `special_argument_1`, `special_argument_2`'
    )
    message = asked(component='a2', task='TASK_A', args={'special_argument_2': 'fast'})
    assert message.startswith('args: `special_argument_2` must be a number')
    assert bench.records('task.started') == []
    answer = asked(component='a2', task='TASK_A', args={'special_argument_2': 2})
    assert answer == 'TASK_A is sent to a2'
    (started,) = bench.records('task.started')
    assert started.args == {'special_argument_2': 2.0}
    bench.pass_time(5.0)
    assert asked(component='a3', task='TASK_A') == 'TASK_A is sent to a3'


def test_7_11_3_only_in_manual_and_without_a_pause() -> None:
    run = VirtualRun(LINE.cell, TYPES)
    assert 'and the line is in remote' in send(run).message
    assert run.ask(ask('cell.local', EVE)).accepted
    assert send(run).message == 'the cell is not in manual mode'
    assert run.ask(ask('cell.manual', EVE)).accepted
    assert run.ask(Pause(ann())).accepted
    assert send(run).message == 'a2 gets no goal: hold 1 (paused, Ann: a test) is open'
    assert run.ask(Resume(ann())).accepted
    assert run.ask(Abort(ann())).accepted
    run.go()
    assert send(run).message == 'a2 gets no goal: the cell is Aborted'
    assert run.ask(Clear(ann(), AsShown(run.state.seq))).accepted
    run.go()
    assert send(run).accepted


# --- what is refused ----------------------------------------------------------------------------


def test_7_11_4_one_goal_at_a_time() -> None:
    run = in_manual()
    assert send(run).accepted
    assert send(run, 'lamp').message == (
        'lamp gets no goal: TASK_A at a2 runs, and manual mode has one goal at a time'
    )
    wait(run, 11.0)
    assert send(run, 'lamp').accepted


def test_7_11_4_unavailable_component_gets_no_goal() -> None:
    line = Line(topics=('a2',), faults={'a2': '#0=not_ready'})
    run = in_manual(line.cell)
    run.go()
    assert run.ask(SetService('a3', False, ann('worn'))).accepted
    assert send(run, 'a3').message == (
        'a3 gets no goal: waiting for a3, which is out of service (Ann: worn)'
    )
    assert 'a2 gets no goal: waiting for /a2/state = READY' in send(run, 'a2').message
    run.sim.gateway.bring_in('b2', Contest(goals=('11111111',)))
    run.sim.orchestrator.settle()
    assert 'b2 gets no goal: ' in send(run, 'b2').message
    assert run.all('task.started') == []


def held_at_home(faults: str = 'TASK_A#1=abort', **more: Any) -> VirtualRun:
    """Return a run that was stopped while initialization at the lamp is held."""
    line = Line(seconds={'lamp': 10.0}, faults={'lamp': faults}, **more)
    run = line.begin(with_initialization('[{id: home, @lamp}]'))
    run.go()
    assert run.ask(Stop(ann())).accepted
    run.go()
    assert run.state.packml is PackmlState.STOPPED
    enter(run)
    return run


def test_7_11_4_a_component_in_doubt_gets_none() -> None:
    run = held_at_home('TASK_A#1=die:1')
    (hold,) = run.state.holds.values()
    assert hold.reason == 'server_lost'
    message = 'lamp gets no goal: it is in doubt; answer hold 1 (home: server_lost) first'
    assert send(run, 'lamp').message == message
    assert send(run, 'lamp', hold='1').message == message


def test_7_11_4_known_end_after_abort_leaves_no_doubt() -> None:
    line = Line(seconds={'lamp': 10.0})
    run = line.begin(with_initialization('[{id: home, @lamp}]'))
    run.go(3.0)
    assert run.ask(Abort(ann())).accepted
    run.go()
    assert run.ask(Clear(ann(), AsShown(run.state.seq))).accepted
    run.go()
    enter(run)
    (hold,) = run.state.holds.values()
    assert hold.reason == 'in_doubt'
    assert 'keeps it; name that hold' in send(run, 'lamp').message
    assert send(run, 'lamp', hold=hold.id).accepted


# --- what a held task keeps ---------------------------------------------------------------------


def test_7_11_5_held_component_runs_only_by_hold_number() -> None:
    run = held_at_home()
    kept = 'lamp gets no goal: hold 1 (home: aborted) keeps it; name that hold: it stays'
    assert send(run, 'lamp').message == kept
    assert send(run, 'lamp', hold='7').message == kept
    assert send(run, 'a2', hold='1').message == 'a2 gets no goal: hold 1 does not keep it'
    assert send(run, 'lamp', hold='1').accepted
    (hold,) = run.state.holds.values()
    assert hold.manual == ('TASK_A',)
    wait(run, 11.0)
    assert send(run, 'lamp', hold='1', task='TASK_B').accepted
    assert run.ask(ask('component.cancel_task', EVE, component='lamp')).accepted
    wait(run, 1.0)
    (hold,) = run.state.holds.values()
    assert hold.manual == ('TASK_A: done', 'TASK_B: canceled')
    assert run.state.reserved['lamp'] == hold.key
    assert run.answer('retry', hold.id).accepted
    assert 'home of J keeps it' in send(run, 'lamp').message
    assert leave(run).accepted
    assert run.ask(Reset(ann())).accepted
    run.go()
    assert run.ask(Start(ann())).accepted
    run.go()
    assert run.job().exit_status == 'completed'


def stopped_at_work(script: str, faults: Mapping[str, str]) -> VirtualRun:
    """Return a run in manual that was stopped while a task is held whose item was taken off."""
    line = Line(faults=faults)
    run = VirtualRun(line.cell, TYPES)
    run.submit('J', line.script(script), 1)
    run.go()
    assert run.state.holds
    assert run.ask(Stop(ann())).accepted
    run.go()
    for item in list(run.state.items):
        assert run.remove(item).accepted
    enter(run)
    return run


def test_7_11_5_held_belt_task_keeps_conveyor() -> None:
    run = stopped_at_work(THREE, {'a2': 'TASK_A#1=abort'})
    assert send(run, 'conveyor', task='MOVE_ONE_INDEX').message == (
        'conveyor gets no goal: hold 1 (work: aborted) keeps it; name that hold: it stays'
    )
    assert send(run, 'conveyor', task='MOVE_ONE_INDEX', hold='1').accepted
    wait(run, 5.0)
    assert ended(run) == 'done'
    assert run.all('belt.indexed') == run.all('belt.indexed')[:1]


def test_7_11_5_zone_kept_by_task_is_not_entered() -> None:
    zoned = with_section(2, '- {id: work, @a2}') + 'zones: {table: [work, pack]}\n'
    run = stopped_at_work(zoned, {'a2': 'TASK_A#1=abort'})
    assert send(run, 'a3').message == ('a3 gets no goal: work of J/1 keeps zone table (hold 1)')
    assert send(run, 'b3').accepted


# --- what is known afterwards -------------------------------------------------------------------


def test_7_11_6_setups_are_unknown_and_once_is_forgotten() -> None:
    line = Line()
    script = with_initialization('[{id: home, @a2, once: true}, {id: lamp, @lamp, once: true}]')
    run = VirtualRun(line.cell, TYPES)
    run.submit('J', line.script(script))
    run.go()
    assert run.state.packml is PackmlState.COMPLETE
    assert run.ask(Reset(ann())).accepted
    run.go()
    enter(run)
    assert len(run.state.done_once) > 2
    assert send(run, 'a2', task='TASK_B').accepted
    assert not [key for key in run.state.done_once if key.startswith('/a2/do ')]
    assert [key for key in run.state.done_once if key.startswith('/lamp/do ')]
    wait(run, 2.0)
    assert leave(run).accepted
    run.submit('K', line.script(script))
    assert run.ask(Start(ann())).accepted
    run.go()
    assert len(run.starts('home')) == 2
    assert len(run.starts('lamp')) == 1


def test_7_11_6_a_change_of_setup_teaches_nothing() -> None:
    line = Line(keys={'a2': SETUPS.replace('nozzle', 'gripper')})
    run = VirtualRun(line.cell, TYPES)
    run.submit('J', line.script(with_section(2, '- {id: work, @a2, setup: {gripper: fine}}')))
    run.go()
    assert run.ask(Reset(ann())).accepted
    run.go()
    assert known(run.state, 'a2', 'gripper') == 'fine'
    enter(run)
    assert send(run, task='TASK_C', args={'special_argument_1': 'wide'}).accepted
    assert known(run.state, 'a2', 'gripper') is None
    wait(run, 3.0)
    assert ended(run) == 'done'
    assert known(run.state, 'a2', 'gripper') is None


# --- the panel ----------------------------------------------------------------------------------


def test_7_11_7_goal_of_silent_panel_is_cancelled() -> None:
    run = in_manual()
    assert send(run).accepted
    begun = run.now
    wait(run, 4.0)
    assert run.all('task.cancel_requested') == []
    wait(run, 1.5, heard=None)
    assert run.all('task.cancel_requested') == []
    wait(run, 1.0, heard=None)
    (cancelled,) = run.all('task.cancel_requested')
    assert cancelled['cause'] == 'panel_lost'
    assert cancelled['time'] == begun + 4.0 + 2.0
    assert ended(run) == 'canceled'
    assert run.state.holds == {}


def test_7_11_7_other_users_do_not_keep_goal_alive() -> None:
    run = in_manual()
    assert send(run).accepted
    before = len(run.records)
    wait(run, 1.5, heard=BEN)
    assert len(run.records) == before
    wait(run, 1.0, heard=BEN)
    assert [record['cause'] for record in run.all('task.cancel_requested')] == ['panel_lost']


def test_7_11_7_sign_of_life_needs_panel_and_role() -> None:
    run = in_manual()
    assert send(run).accepted
    viewer = By('Eve', 'panel 3', '', Role.VIEW, Known.PAGE_PANEL)
    remote = By('Eve', 'panel 3', '', Role.ENGINEER, Known.PAGE_LOGIN)
    assert not run.ask(ask('cell.at_panel', viewer)).accepted
    assert not run.ask(ask('cell.at_panel', remote)).accepted
    wait(run, 11.0)
    assert leave(run).accepted
    assert run.ask(ask('cell.at_panel', EVE)).message == 'the cell is not in manual mode'


def test_7_11_7_cancel_and_abort_end_it() -> None:
    run = in_manual()
    bob = By('Bob', 'home', '', Role.OPERATE, Known.PAGE_LOGIN)
    cancel = ask('component.cancel_task', bob, component='a2')
    assert run.ask(cancel).message == 'a2 has no goal of manual mode'
    assert send(run).accepted
    wait(run, 1.0)
    assert run.ask(cancel).message == 'TASK_A at a2 is being cancelled'
    wait(run, 1.0)
    assert ended(run) == 'canceled'
    assert send(run).accepted
    wait(run, 1.0)
    assert run.ask(Abort(ann())).accepted
    wait(run, 1.0)
    assert run.state.packml is PackmlState.ABORTED
    (hold,) = run.state.holds.values()
    assert (hold.reason, hold.answers) == ('in_doubt', ('skip',))


def test_7_11_7_where_the_journal_fails_the_goal_is_cancelled() -> None:
    run = in_manual()
    assert send(run).accepted
    wait(run, 1.0)
    (goal,) = (task.goal for task in run.state.running.values())
    assert goal is not None
    flight = run.sim.orchestrator.flights.goal(goal)
    assert flight is not None

    def full(_: Sequence[e.Event]) -> None:
        raise JournalFailed('disk full')

    run.store.append = full  # type: ignore[assignment, method-assign]
    assert not run.sim.orchestrator.ask(Pause(ann())).accepted
    while flight.end is None and run.sim.clock.advance():
        run.sim.orchestrator.settle()
    assert flight.end is not None
    assert flight.end.status.value == 'canceled'


# --- how it ends --------------------------------------------------------------------------------


def test_7_11_8_a_goal_that_fails_is_over() -> None:
    line = Line(faults={'a2': 'TASK_A#1=abort:jam TASK_A#2=reject'})
    run = in_manual(line.cell)
    assert send(run).accepted
    wait(run, 2.0)
    goal = run.sim.status().manual
    assert goal is not None
    assert (goal.state, run.state.holds, run.state.reserved) == ('aborted', {}, {})
    assert send(run).accepted
    wait(run, 2.0)
    assert ended(run) == 'goal_rejected'
    assert send(run).accepted


def test_7_11_8_a_goal_in_doubt_waits_for_an_answer() -> None:
    line = Line(faults={'a2': 'TASK_A#1=ignore_cancel'})
    run = in_manual(line.cell)
    assert send(run).accepted
    wait(run, 1.0)
    wait(run, 8.0, heard=None)
    (hold,) = run.state.holds.values()
    assert (hold.reason, hold.component, hold.answers) == ('in_doubt', 'a2', ('skip',))
    assert list(run.state.reserved) == ['a2']
    assert send(run, 'lamp').message == ('lamp gets no goal: hold 1 (manual: in_doubt) is open')
    assert leave(run).message == (
        'it is open how TASK_A at a2 ended; answer hold 1 (manual: in_doubt) first'
    )
    assert run.ask(AnswerHold('1', 'skip', ann('it stands'))).accepted
    assert run.state.reserved == {}
    assert send(run, 'lamp').accepted


# --- restarts -----------------------------------------------------------------------------------


def killed_in_manual(world: World, *, before_sending: bool = False) -> None:
    first = world.orchestrator()
    enter(first)
    if before_sending:
        world.gateway.send = lambda request: None  # type: ignore[assignment,method-assign,return-value]
    assert send(first).accepted
    if not before_sending:
        world.clock.advance()  # the request reaches the server
    first.close()


def go_on(world: World, engine: Orchestrator, seconds: float, heard: By | None = None) -> None:
    until = world.clock.now() + seconds
    while world.clock.now() < until:
        world.clock.call_at(min(world.clock.now() + 0.5, until), lambda: None)
        assert world.clock.advance()
        if heard is not None:
            assert engine.ask(ask('cell.at_panel', heard)).accepted
        engine.settle()


def test_7_11_9_restart_adopts_goal_while_panel_is_heard() -> None:
    world = World(LINE.cell)
    killed_in_manual(world)
    second = world.orchestrator()
    go_on(world, second, 12.0, heard=EVE)
    (started,) = world.events(e.TaskStarted)
    (adopted,) = world.events(e.TaskAdopted)
    (done,) = world.events(e.TaskSucceeded)
    assert vars(started)['goal'] == vars(adopted)['goal'] == vars(done)['goal']
    assert world.events(e.TaskCancelRequested) == []


def test_7_11_9_a_restart_without_its_panel_cancels_the_goal() -> None:
    world = World(LINE.cell)
    killed_in_manual(world)
    second = world.orchestrator()
    go_on(world, second, 5.0)
    (cancelled,) = world.events(e.TaskCancelRequested)
    assert vars(cancelled)['cause'] == 'panel_lost'
    (failed,) = world.events(e.TaskFailed)
    assert vars(failed)['reason'] == 'canceled'


def test_7_11_9_goal_never_received_is_not_resent() -> None:
    world = World(LINE.cell)
    killed_in_manual(world, before_sending=True)
    second = world.orchestrator()
    go_on(world, second, 5.0, heard=EVE)
    (failed,) = world.events(e.TaskFailed)
    assert (vars(failed)['reason'], vars(failed)['never_begun']) == ('server_unavailable', True)
    assert world.events(e.TaskResent) == []
    assert second.state.holds == {}
    assert len(world.events(e.TaskStarted)) == 1


# --- leaving ------------------------------------------------------------------------------------


def test_7_11_10_leaving_takes_a_statement_of_the_belt() -> None:
    run = in_manual()
    assert send(run).accepted
    assert 'a goal of manual mode runs' in leave(run).message
    wait(run, 11.0)
    wrong = leave(run, belt=Slots({1: 'J/1', 2: 'empty', 3: 'empty'})).message
    assert wrong.startswith('slot 1: the cell believes empty, not J/1')
    run.submit('J', LINE.script(THREE))
    assert leave(run, belt=Slots({1: 'empty', 2: 'empty', 3: 'empty'})).message == (
        'manual mode has ended; reset and start let the cell go on'
    )
    assert run.state.manual is None
    assert leave(run).message == 'the cell is not in manual mode'
    run.go()
    assert run.state.packml.value == 'Stopped'
    status = run.sim.status()
    assert status.wish is not None
    assert (status.wish.command, status.waits_for) == ('production', 'reset and start')
    assert run.ask(Reset(ann())).accepted
    run.go()
    assert run.state.packml.value == 'Idle'
    assert run.ask(Start(ann())).accepted
    run.go()
    assert run.job().exit_status == 'completed'


def test_7_11_10_belt_statement_uses_request_name(tmp_path: Any) -> None:
    bench = RequestBench(tmp_path)
    enter(bench.sim)
    answer = begin(bench.handler.carry_out(ask('cell.production', EVE))).value
    assert answer.message.startswith('production needs to know what stands on the belt: either')
    assert engineer('x').known.is_panel
