"""Semantics 2: tasks, their ends, retries and policies."""

from __future__ import annotations

import pytest
from fakes.commands import Abort, Stop
from fakes.line import THREE, Line, with_section
from fakes.virtual_run import VirtualRun

from bt_orchestrator.model.goal import Contest, GoalEnd, GoalStatus

WORK_AT = 3.0
"""When section 2 of the shortest line begins with its first item."""


VERDICT = ', fails_unless: {value: "${results.work.measurement}", at_most: 1.5}'
"""An option of the task `work`."""


def work(options: str = '') -> str:
    """Return the shortest line, with options for the task of section 2."""
    return with_section(2, f'- {{id: work, @a2{", " + options if options else ""}}}')


def faulty(fault: str, options: str = '', *, quantity: int = 1) -> VirtualRun:
    """Run the shortest line with a fault of the component in section 2."""
    return Line(faults={'a2': fault}).run(work(options), quantity)


# --- 2.2 ------------------------------------------------------------------------------------


def test_2_2_a_task_succeeds_with_its_result_fields() -> None:
    run = Line(results={'a2': {'measurement': 4.5}}).run(work())
    (done,) = run.all('task.succeeded', task='work')
    assert done['time'] == WORK_AT + 1
    assert done['results'] == {'item_present': True, 'measurement': 4.5}


def test_2_2_succeeded_with_task_result_false_is_a_failure() -> None:
    run = faulty('#1=false', 'on_failure: continue')
    assert run.times('task.failed', task='work', reason='task_result_false') == [WORK_AT + 1]
    assert run.all('task.succeeded', task='work') == []


# --- 2.3 ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ('fault', 'reason', 'after_s'),
    [
        ('#1=false', 'task_result_false', 1),
        ('#1=reject', 'goal_rejected', 0),
        ('#1=abort', 'aborted', 1),
        ('#1=cancel', 'in_doubt', 1),
        ('#0=absent', 'server_unavailable', 5),
        ('#1=hang', 'timeout', 10),
        ('#1=ignore_cancel', 'in_doubt', 15),
        ('#1=mute', 'server_lost', 4),
        ('#1=die', 'server_lost', 20.5),
        ('#1=die:1', 'server_lost', 2),
    ],
)
def test_2_3_every_end_has_its_own_reason(fault: str, reason: str, after_s: float) -> None:
    run = faulty(fault, 'timeout: 10' if 'die' not in fault else 'timeout: none')
    (failed,) = run.all('task.failed')
    assert (failed['reason'], failed['time']) == (reason, WORK_AT + after_s)
    (hold,) = run.state.holds.values()
    assert (hold.task, hold.section, hold.item, hold.reason) == ('work', 2, 'J/1', reason)


def test_2_3_missing_result_ends_the_attempt_without_a_goal() -> None:
    text = with_section(
        2,
        """
        - {id: look, @a2, on_failure: continue}
        - {id: use, @b2, args: {special_argument_2: "${results.look.measurement}"}, retries: 3}
        """,
    )
    run = Line(faults={'a2': '#1=abort'}).run(text)
    (failed,) = run.all('task.failed', task='use')
    assert failed['reason'] == 'missing_result'
    assert 'goal' not in failed
    assert run.starts('use') == []
    assert failed['message'] == (
        '${results.look.measurement} has no value: that task gave no result for this item'
    )


# --- 2.4 ------------------------------------------------------------------------------------


def test_2_4_timeout_cancels_goal_and_awaits_its_end() -> None:
    run = faulty('#1=hang', 'timeout: 2.5')
    assert run.times('task.cancel_requested', cause='timeout') == [WORK_AT + 2.5]
    assert run.times('task.failed', reason='timeout') == [WORK_AT + 2.5]


def test_2_4_missing_terminal_status_is_in_doubt_after_grace() -> None:
    run = faulty('#1=ignore_cancel', 'timeout: 2.5, retries: 3, on_failure: continue')
    assert run.times('task.failed', reason='in_doubt') == [WORK_AT + 2.5 + 5]
    assert run.starts('work') == [WORK_AT]
    assert run.state.reserved['a2'].task == 'work'
    assert [hold.reason for hold in run.state.holds.values()] == ['in_doubt']


def test_2_4_grace_restarts_when_abort_cancels_again() -> None:
    line = Line(seconds={'a1': 6.0}, faults={'a2': '#1=ignore_cancel'})
    run = line.begin(work('timeout: 2.5'), 2).go(until=14.5)
    assert run.command(Abort).accepted  # at 14, when the second item was placed
    run.go()
    assert run.times('task.cancel_requested', task='work') == [10.5, 14.0]
    assert run.times('task.failed', reason='in_doubt') == [19.0]


def test_2_4_the_components_timeout_and_300_s_are_the_defaults() -> None:
    run = faulty('#1=hang')
    assert run.times('task.failed', reason='timeout') == [WORK_AT + 300]


def test_2_4_no_limit_has_to_be_written() -> None:
    run = Line(faults={'a2': '#1=late:5000'}).run(work('timeout: none'))
    assert run.times('task.succeeded', task='work') == [WORK_AT + 5001]


def test_2_4_a_goal_in_time_is_not_cancelled() -> None:
    run = faulty('#1=late:1.4', 'timeout: 2.5')
    assert run.all('task.cancel_requested') == []
    assert run.times('task.succeeded', task='work') == [WORK_AT + 2.4]


# --- 2.5 ------------------------------------------------------------------------------------


def test_2_5_one_component_runs_one_task_at_a_time() -> None:
    text = """
    sections:
      1: [{id: place, @a1, qty_change: 1}]
      2: [{id: two, @arm}]
      3: [{id: three, @arm}, {id: pack, @a3, qty_change: -1}]
    """
    run = Line().run(text, 2)
    assert run.starts('three', item='J/1') == [6.0]
    assert run.starts('two', item='J/2') == [7.0]
    run = Line().begin(text, 2).go(until=6.0)
    assert run.waits()['section 2'] == 'waiting for arm, busy with three of J/1'


SHARED = """
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2: [{id: two, @arm}]
  3: [{id: three, @arm}, {id: pack, @a3, qty_change: -1, runs_for: all}]
"""


@pytest.mark.parametrize('fault', ['#2=abort', '#2=false', '#2=reject', '#2=hang'])
def test_2_5_a_held_task_keeps_its_component(fault: str) -> None:
    run = Line(faults={'arm': fault}).run(SHARED, 2)
    assert run.state.packml.value == 'Held'
    assert run.starts('two') == [3.0]
    assert run.waits()['section 2'] == (
        'waiting for arm, busy with three of J/1, which waits for an answer to hold 1'
    )


@pytest.mark.parametrize('answer', ['retry', 'mark_done', 'skip', 'reject', 'abort_job'])
def test_2_5_the_line_goes_on_with_every_answer(answer: str) -> None:
    run = Line(faults={'arm': '#2=abort'}).run(SHARED, 2)
    at = run.now
    run.answer(answer)
    run.go()
    assert run.ended
    if answer == 'retry':
        assert run.starts('three')[:2] == [6.0, at]
        assert run.starts('two') == [3.0, at + 1]


def test_2_5_the_held_move_keeps_the_conveyor() -> None:
    run = Line(belt='on_failure: abort_job', faults={'conveyor': '#1=abort'}).run(SHARED, 2)
    assert run.state.reserved['conveyor'].task == 'index'
    run.answer('retry')
    run.go()
    assert run.ended
    assert not run.state.reserved


def test_2_5_what_never_took_its_component_keeps_none() -> None:
    """An attempt that ends with `missing_result` ends before it begins (2.6)."""
    text = """
    sections:
      1: [{id: place, @a1, qty_change: 1}]
      2: [{id: look, @a2, on_failure: continue},
          {id: two, @arm, args: {special_argument_2: "${results.look.measurement}"}}]
      3: [{id: three, @arm}, {id: pack, @a3, qty_change: -1}]
    """
    run = Line(faults={'a2': '#1=abort'}).run(text)
    assert [hold.reason for hold in run.state.holds.values()] == ['missing_result']
    assert not run.state.reserved


def test_2_5_component_that_is_not_ready_gets_no_goal() -> None:
    line = Line(topics=('a2',), faults={'a2': '#0=not_ready:8'})
    run = line.begin(work()).go(until=5.0)
    assert run.waits()['section 2'] == 'waiting for /a2/state = READY; it is NOT_READY'
    run.go()
    assert run.starts('work') == [8.0]


def test_2_5_a_component_that_says_nothing_is_not_ready() -> None:
    run = Line(topics=('a2',), faults={'a2': '#0=silent'}).run(work())
    assert run.starts('work') == []
    assert run.waits()['section 2'] == (
        'waiting for /a2/state = READY; nothing is published there'
    )


BELT_TOPIC = 'state: {topic: /belt/state, type: std_msgs/msg/String, field: data, ready: [READY]}'


@pytest.mark.parametrize(
    ('fault', 'reading'), [('#0=not_ready', 'it is'), ('#0=silent', 'nothing')]
)
def test_2_5_belt_rests_while_conveyor_is_not_ready(fault: str, reading: str) -> None:
    run = Line(faults={'conveyor': fault}, belt=BELT_TOPIC).run()
    assert not run.all('belt.index_started')
    assert not run.all('task.started', component='conveyor')
    assert run.waits()['belt'].startswith(f'waiting for /belt/state = READY; {reading}')
    assert run.states[-1] == 'Execute'


def test_2_5_belt_moves_once_conveyor_is_ready_again() -> None:
    run = Line(faults={'conveyor': '#1=not_ready:7'}, belt=BELT_TOPIC).run()
    first, second, *_ = run.times('belt.index_started')
    assert second == first + 2.0 + 7.0
    assert run.counts()['packed'] == 1


def test_2_5_failed_move_is_repeated_once_conveyor_is_ready() -> None:
    faults = {'conveyor': '#1=abort #1=not_ready:7'}
    run = Line(faults=faults, belt=f'retries: 1, {BELT_TOPIC}').run()
    first, again, *_ = run.times('task.started', component='conveyor')
    assert again == first + 2.0 + 7.0
    assert len(run.times('belt.index_started')) == len(run.times('belt.indexed'))


def test_2_5_readiness_is_asked_again_for_the_next_item() -> None:
    run = Line(topics=('a2',), faults={'a2': '#1=not_ready:20'}).run(work(), 2)
    assert run.starts('work') == [3.0, 24.0]


def test_2_5_component_with_two_servers_gets_no_goal() -> None:
    run = Line().begin(work())
    bring_in(run, 'a2', servers=('/one', '/two'))
    run.go(until=5.0)
    assert run.waits()['section 2'] == (
        'waiting for a2 to have one server; there are 2 servers of /a2/do: /one, /two; '
        'stop all but one'
    )
    [event] = run.all('component.contested')
    assert (event['component'], event['servers']) == ('a2', ['/one', '/two'])
    assert run.state.stop_reason is None
    assert run.starts('work') == []
    bring_in(run, 'a2')
    run.go()
    assert len(run.starts('work')) == 1
    assert run.ended


def test_2_5_two_conveyor_servers_keep_belt_at_rest() -> None:
    run = Line().begin()
    bring_in(run, 'conveyor', servers=('/one', '/two'))
    run.go(until=5.0)
    assert run.starts('index') == run.times('belt.index_started') == []
    assert run.waits()['belt'].startswith('waiting for conveyor to have one server')
    assert run.states[-1] == 'Execute'
    bring_in(run, 'conveyor')
    assert run.go().ended


def test_2_5_second_conveyor_server_is_checked_before_move() -> None:
    """It may be there before anybody was told of it."""
    run = Line().begin(work())
    run.sim.gateway._clients['conveyor'].contest = Contest(('/one', '/two'))
    run.go(until=5.0)
    assert run.starts('index') == run.times('belt.index_started') == []
    assert run.waits()['belt'].startswith('waiting for conveyor to have one server')


def test_2_5_second_server_is_checked_at_task_start() -> None:
    """It may be there before anybody was told of it."""
    run = Line().begin(work())
    run.go(until=2.5)
    client = run.sim.gateway._clients['a2']
    client.contest = Contest(('/one', '/two'))
    run.go(until=5.0)
    assert run.starts('work') == []
    assert run.waits()['section 2'].startswith('waiting for a2 to have one server')


def test_2_5_running_goal_continues_beside_second_server() -> None:
    run = Line().begin(work()).go(until=3.5)
    bring_in(run, 'a2', servers=('/one', '/two'))
    run.go(until=4.0)
    assert run.times('task.succeeded', task='work') == [4.0]
    assert run.go().ended


def test_2_5_stop_waits_for_cycle_blocked_by_second_server() -> None:
    run = Line().begin(work(), 2)
    bring_in(run, 'a2', servers=('/one', '/two'))
    run.go(until=5.0)
    run.command(Stop)
    run.go(until=10.0)
    assert run.states[-1] == 'Stopping'
    assert run.starts('work') == []
    bring_in(run, 'a2')
    run.go()
    assert run.states[-1] == 'Stopped'
    assert len(run.starts('work')) == 1


def test_2_5_two_source_servers_are_no_material_shortage() -> None:
    run = Line().begin(quantity=2)
    bring_in(run, 'a1', servers=('/one', '/two'))
    run.go()
    assert run.starts('place') == [0.0]
    assert run.waits()['section 1'].startswith('waiting for a1 to have one server')
    assert run.states[-1] == 'Execute'


def test_2_5_component_with_foreign_goal_is_not_free() -> None:
    run = Line().begin(work())
    bring_in(run, 'a2', goals=('of-hmi',))
    run.go(until=5.0)
    assert run.waits()['section 2'] == (
        'waiting for a2; it runs goal of-hmi, which no task here waits for'
    )
    assert run.starts('work') == []
    bring_in(run, 'a2')
    assert run.go().ended


def bring_in(
    run: VirtualRun, component: str, servers: tuple[str, ...] = (), goals: tuple[str, ...] = ()
) -> None:
    """Let others have a part in a component, or nobody any more."""
    run.sim.gateway.bring_in(component, Contest(servers, goals))
    run.sim.orchestrator.settle()


# --- 2.6 ------------------------------------------------------------------------------------


def test_2_6_failed_attempt_is_repeated_after_delay() -> None:
    run = faulty('#1=abort #2=reject #3=false', 'retries: 3, retry_delay: 1.5')
    assert run.starts('work') == [3.0, 5.5, 7.0, 9.5]
    assert [r['attempt'] for r in run.all('task.started', task='work')] == [1, 2, 3, 4]
    assert run.ended
    assert run.counts()['packed'] == 1


def test_2_6_while_it_waits_to_retry_it_says_so() -> None:
    line = Line(faults={'a2': '#1=abort'})
    run = line.begin(work('retries: 1, retry_delay: 5')).go(until=4.0)
    assert run.waits()['section 2'] == 'waiting to retry, attempt 2'


def test_2_6_every_attempt_has_a_goal_of_its_own() -> None:
    run = faulty('#1=abort', 'retries: 1')
    goals = [record['goal'] for record in run.all('task.started')]
    assert len(goals) == len(set(goals)) == 6


def test_2_6_after_the_last_attempt_the_policy_decides() -> None:
    run = faulty('#1=abort #2=abort #3=abort', 'retries: 2')
    assert run.starts('work') == [3.0, 4.0, 5.0]
    assert run.times('hold.raised') == [6.0]


def test_2_6_lost_server_raises_hold_and_keeps_component() -> None:
    run = faulty('#1=die:1', 'retries: 2, on_failure: continue')
    assert run.starts('work') == [WORK_AT]
    assert run.state.reserved['a2'].task == 'work'
    run.answer('retry')
    run.go()
    assert run.starts('work') == [3.0, 5.0]
    assert run.ended


def test_2_6_server_lost_of_a_repeatable_task_is_retried() -> None:
    run = faulty('#1=die:1', 'retries: 1, repeatable: true')
    assert run.reasons() == ['server_lost']
    assert run.starts('work') == [3.0, 5.0]
    assert run.ended


def test_2_6_lost_server_of_repeatable_task_follows_policy() -> None:
    run = faulty('#1=die:1', 'on_failure: continue, repeatable: true')
    assert run.all('hold.raised') == []
    assert run.counts()['nonconforming'] == 1


@pytest.mark.parametrize('policy', ['hold', 'continue', 'reject', 'abort_job'])
def test_2_6_foreign_cancel_is_in_doubt_under_any_policy(policy: str) -> None:
    text = work(f'retries: 3, repeatable: true, on_failure: {policy}')
    text = text.replace('qty_change: -1', 'qty_change: -1, runs_for: all')
    run = Line(faults={'a2': '#1=cancel'}).run(text)
    (failed,) = run.all('task.failed')
    assert failed['reason'] == 'in_doubt'
    assert failed['message'].startswith('cancelled by somebody else')
    assert run.starts('work') == [WORK_AT]
    assert [hold.reason for hold in run.state.holds.values()] == ['in_doubt']
    assert run.state.reserved['a2'].task == 'work'
    assert run.answer('retry').accepted
    assert run.go().ended


def test_2_6_foreign_cancel_of_move_is_in_doubt() -> None:
    run = Line(faults={'conveyor': '#1=cancel'}, belt='retries: 2, on_failure: abort_job').run()
    assert run.reasons() == ['in_doubt']
    (hold,) = run.state.holds.values()
    assert (hold.task, hold.reason) == ('index', 'in_doubt')
    assert not run.all('job.aborting')


@pytest.mark.parametrize('policy', ['hold', 'continue', 'abort_job'])
@pytest.mark.parametrize('answer', ['retry', 'mark_done', 'skip'])
def test_2_6_initialization_that_somebody_else_cancelled_is_in_doubt(
    policy: str, answer: str
) -> None:
    options = f'retries: 2, repeatable: true, once: true, on_failure: {policy}'
    run = Line(faults={'b1': '#1=cancel'}).run(
        f'initialization: [{{id: ready, @b1, {options}}}]{THREE}'
    )
    assert run.reasons() == ['in_doubt']
    assert run.starts('ready') == [0.0]
    assert run.starts('place') == []
    (hold,) = run.state.holds.values()
    assert (hold.task, hold.answers) == ('ready', ('retry', 'mark_done', 'skip', 'abort_job'))
    assert run.answer(answer).accepted
    run.go()
    assert run.ended
    assert len(run.starts('ready')) == (2 if answer == 'retry' else 1)
    assert run.counts()['packed'] == 1


def test_2_6_own_cancel_by_abort_job_is_no_failure() -> None:
    text = with_section(
        2,
        """
        - parallel:
          - {id: work, @a2, retries: 3}
          - {id: bad, @b2, on_failure: abort_job}
        """,
    ).replace('qty_change: -1', 'qty_change: -1, runs_for: all')
    run = Line(seconds={'a2': 9.0}, faults={'b2': '#1=abort'}).run(text)
    assert run.times('task.cancel_requested', task='work', cause='abort_job') == [4.0]
    assert run.starts('work') == [3.0]
    assert run.order('task.continued', 'policy') == ['abort_job', 'abort_job']
    assert run.all('hold.raised') == []
    assert run.counts()['rejected'] == 1


@pytest.mark.parametrize(
    ('end', 'options', 'message', 'hold'),
    [
        (GoalEnd(GoalStatus.CANCELED), '', 'task.continued', ''),
        (GoalEnd(GoalStatus.ABORTED), '', 'task.continued', ''),
        (GoalEnd(GoalStatus.SUCCEEDED, {'task_result': False}), '', 'task.continued', ''),
        (GoalEnd(GoalStatus.SUCCEEDED, {'measurement': 9.0}), VERDICT, 'task.continued', ''),
        (GoalEnd(GoalStatus.LOST), ', repeatable: true', 'task.continued', ''),
        (GoalEnd(GoalStatus.SUCCEEDED, {'measurement': 1.0}), VERDICT, 'task.succeeded', ''),
        (GoalEnd(GoalStatus.LOST), '', 'hold.raised', 'server_lost'),
        (GoalEnd(GoalStatus.SILENT), '', 'hold.raised', 'in_doubt'),
    ],
)
def test_2_6_whatever_end_follows_the_cancel_of_abort_job(
    end: GoalEnd, options: str, message: str, hold: str
) -> None:
    text = with_section(2, f'- {{id: work, @a2, retries: 3{options}}}').replace(
        'qty_change: -1', 'qty_change: -1, runs_for: all'
    )
    run = Line(faults={'a2': '#1=ignore_cancel'}).begin(text).go(until=3.5)
    assert run.control('abort', 'J').accepted
    (goal,) = (goal for _, goal in run.sim.orchestrator.flights.without_end.values())
    run.sim.gateway._clients['a2'].end(goal, end)  # type: ignore[arg-type]
    run.sim.orchestrator.settle()
    assert run.all(message, task='work')
    assert [open_hold.reason for open_hold in run.state.holds.values()] == [hold][: bool(hold)]
    assert run.starts('work') == [3.0]
    assert run.go().ended is not bool(hold)


def test_2_4_cancel_precedes_end_of_instant_goal() -> None:
    run = Line(seconds={'a2': 0.0}).begin(work())
    clock, orchestrator = run.sim.clock, run.sim.orchestrator
    orchestrator.settle()
    while not run.starts('work'):
        clock.advance()
        orchestrator.settle()
    assert run.command(Abort).accepted
    run.go()
    assert run.reasons() == ['in_doubt']
    assert not run.all('task.succeeded', task='work')


def test_2_6_other_failures_keep_policy_in_aborting_job() -> None:
    text = with_section(2, '- {id: work, @a2, on_failure: abort_job}').replace(
        'qty_change: -1', 'qty_change: -1, runs_for: all, retries: 1'
    )
    run = Line(faults={'a2': '#1=abort', 'a3': '#1=abort #2=abort'}).run(text)
    assert run.starts('pack') == [6.0, 7.0]
    assert [hold.task for hold in run.state.holds.values()] == ['pack']
    run.answer('retry')
    run.go()
    assert run.counts()['rejected'] == 1


# --- 2.7 ------------------------------------------------------------------------------------


def test_2_7_hold_is_the_default() -> None:
    run = faulty('#1=abort')
    assert run.times('hold.raised', task='work', reason='aborted') == [4.0]


@pytest.mark.parametrize('option', ['on_failure: continue', 'continue_if_fail: true'])
def test_2_7_continue_marks_the_item_nonconforming(option: str) -> None:
    run = Line(faults={'a2': '#1=abort'}).begin(work(option), 2).go(until=4.0)
    assert run.state.items['J/1'].nonconforming == ['work']
    run.go()
    assert run.ended
    assert run.counts() == {
        'started': 2,
        'placed': 2,
        'processed': 2,
        'packed': 2,
        'nonconforming': 1,
    }


def test_2_7_an_item_is_nonconforming_once() -> None:
    text = with_section(
        2, '[{id: one, @a2, on_failure: continue}, {id: two, @b2, on_failure: continue}]'
    )
    run = Line(faults={'a2': '#1=abort', 'b2': '#1=abort'}).run(text)
    assert run.counts()['nonconforming'] == 1


def test_2_7_reject_rejects_the_item() -> None:
    text = work('on_failure: reject').replace('qty_change: -1', 'qty_change: -1, runs_for: all')
    run = Line(faults={'a2': '#1=abort'}).run(text, 2)
    assert run.times('item.rejected', item='J/1') == [4.0]
    assert run.counts()['rejected'] == 1
    assert run.counts()['packed'] == 1


def test_2_7_abort_job_rejects_items_and_stops_placing() -> None:
    text = work('on_failure: abort_job').replace('qty_change: -1', 'qty_change: -1, runs_for: all')
    run = Line(faults={'a2': '#1=abort'}).run(text, 9)
    assert run.times('job.aborting') == [4.0]
    assert run.counts() == {'started': 2, 'placed': 2, 'rejected': 2}
    assert run.times('job.aborted') == [10.0]


def test_2_6_task_for_all_items_retries_rejected_item() -> None:
    text = """
    - parallel:
      - {id: look, @a2, on_failure: reject}
      - {id: clean, @b2, OPTIONS, retries: 1}
    """
    line = Line(seconds={'b2': 2.0}, faults={'a2': '#1=abort', 'b2': '#1=abort'})
    tries = {}
    for options in ('runs_for: all', 'runs_for: good'):
        whole = with_section(2, text.replace('OPTIONS', options))
        run = line.run(whole.replace('qty_change: -1', 'qty_change: -1, runs_for: all'))
        assert run.ended
        tries[options] = len(run.starts('clean'))
    assert tries == {'runs_for: all': 2, 'runs_for: good': 1}


def test_2_4_waiting_for_server_counts_towards_timeout() -> None:
    run = faulty('=absent', 'timeout: 2.0')
    assert run.reasons() == ['timeout']
    assert run.times('task.failed') == [WORK_AT + 2.0]
