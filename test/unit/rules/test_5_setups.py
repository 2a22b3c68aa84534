"""Semantics 5.3: setups of components, and the changes that tasks imply."""

from __future__ import annotations

import json
from collections.abc import Mapping

import pytest
from fakes.commands import Reset, Start, Stop
from fakes.line import Line, with_section
from fakes.virtual_run import VirtualRun

from bt_orchestrator.base.errors import Refused
from bt_orchestrator.model.jobs.setups import known
from bt_orchestrator.model.keeping.snapshot import state_to_plain
from bt_orchestrator.sim.run_on import expected_ends
from bt_orchestrator.view.screen.words import setup_words, status_lines

GRIPPER = (
    'setups: {gripper: [small, large]}, '
    'changes: {gripper: {task: TASK_C, argument: special_argument_1}}'
)
SMALL = with_section(2, '- {id: work, @a2, setup: {gripper: small}}')
LARGE = SMALL.replace('small', 'large')
BOTH = with_section(
    2,
    """
    - {id: one, @a2, setup: {gripper: small}}
    - {id: to_large, @a2.TASK_C, args: {special_argument_1: large}, runs_for: all}
    - {id: two, @a2, setup: {gripper: large}}
    - {id: to_small, @a2.TASK_C, args: {special_argument_1: small}, runs_for: all}
    """,
)


def gripped(
    component: str = 'a2', seconds: Mapping[str, float] | None = None, **faults: str
) -> Line:
    return Line(keys={component: GRIPPER}, seconds=seconds, faults=faults)


def changes(run: VirtualRun) -> list[tuple[float, str, str]]:
    """Return when each change began, for which job, and to what."""
    return [
        (record['time'], record['job'], record['args']['special_argument_1'])
        for record in run.all('task.started', name='TASK_C')
    ]


def stopped_and_started(run: VirtualRun) -> None:
    run.command(Stop)
    run.go(until=run.now + 5.0)
    assert run.state.packml.value == 'Stopped'
    run.command(Reset)
    run.command(Start)


def test_5_3_component_is_set_up_before_first_task() -> None:
    run = gripped().run(SMALL, 2)
    assert run.ended
    assert changes(run) == [(0.0, 'J', 'small')]
    assert known(run.state, 'a2', 'gripper') == 'small'


def test_5_3_a_change_happens_only_where_the_setup_differs() -> None:
    line = gripped()
    run = line.begin(SMALL)
    for name, text in (('K', SMALL), ('L', LARGE), ('M', LARGE)):
        run.submit(name, line.script(text), 1)
    run.go()
    assert run.ended
    assert [(job, value) for _, job, value in changes(run)] == [('J', 'small'), ('L', 'large')]


def test_5_3_change_waits_for_section_not_for_line() -> None:
    line = gripped()
    run = line.begin(SMALL, 2)
    run.submit('K', line.script(LARGE), 1)
    run.go()
    ((_, _, _), (begun, job, _)) = changes(run)
    assert job == 'K'
    assert begun == max(run.times('cycle.completed', section=2, job='J'))
    assert begun < run.times('job.completed', job='J')[0]


def test_5_3_change_is_decided_when_it_could_start() -> None:
    """The job between, which needs another gripper, leaves the queue after K was queued."""
    line = gripped()
    run = line.begin(SMALL, 2)
    run.submit('K', line.script(LARGE), 1)
    run.submit('L', line.script(SMALL), 1)
    run.control('cancel', 'K')
    run.go()
    assert changes(run) == [(0.0, 'J', 'small')]
    assert run.all('task.skipped', job='L')[0]['reason'] == 'set up'


def test_5_3_matching_shared_component_does_not_drain_line() -> None:
    line = gripped('arm')
    text = with_section(2, '- {id: work, @arm, setup: {gripper: small}}')
    run = line.begin(text, 3)
    run.submit('K', line.script(text), 1)
    run.go()
    assert [job for _, job, _ in changes(run)] == ['J']
    begun = run.times('cycle.started', section=1, job='K')[0]
    assert begun < run.times('job.completed', job='J')[0]


def test_5_3_shared_component_waits_for_earlier_change() -> None:
    line = gripped('arm')
    text = with_section(2, '- {id: work, @arm, setup: {gripper: small}}')
    run = line.begin(text, 2)
    run.submit('K', line.script(text.replace('small', 'large')), 1)
    run.submit('L', line.script(text), 1)
    run.go()
    assert run.ended
    assert [(job, value) for _, job, value in changes(run)] == [
        ('J', 'small'),
        ('K', 'large'),
        ('L', 'small'),
    ]


def test_5_3_temporary_setup_of_earlier_job_is_ignored() -> None:
    """Section 2 has the large gripper for a task of J, and the small one when K comes."""
    line = gripped(seconds={'a2': 5.0})
    run = line.begin(BOTH, 1)
    run.submit('K', line.script(LARGE), 1)
    run.go()
    assert run.ended
    assert not run.all('hold.raised')
    assert run.starts('a2.gripper.large', job='K') == run.times(
        'cycle.completed', section=2, job='J'
    )


def test_5_3_changes_in_a_list_are_ordinary_tasks() -> None:
    run = gripped().run(BOTH, 2)
    assert run.ended
    assert run.order('task.started').count('to_large') == 2
    assert run.all('task.skipped', task='a2.gripper.large')[0]['reason'] == 'not asked for'
    assert not run.all('hold.raised')


def test_5_3_it_comes_behind_the_initialization_of_the_component() -> None:
    line = gripped()
    run = line.begin(
        """
initialization: [{id: home, @belt.HOME}, {id: ready, @a2.PREPARE}]
initialization_dependencies: [{upstream: home, downstream: ready}]"""
        + SMALL
    )
    run.go()
    assert run.order('task.succeeded')[:3] == ['home', 'ready', 'a2.gripper.small']


def test_5_3_failed_change_is_held_and_retried() -> None:
    run = gripped(a2='TASK_C#1=abort').run(SMALL)
    (hold,) = run.state.holds.values()
    assert (hold.task, hold.reason) == ('a2.gripper.small', 'aborted')
    assert known(run.state, 'a2', 'gripper') is None
    run.answer('retry')
    run.go()
    assert run.ended


def test_5_3_a_change_that_is_marked_done_is_known() -> None:
    run = gripped(a2='TASK_C#1=abort').run(SMALL)
    run.answer('mark_done')
    assert known(run.state, 'a2', 'gripper') == 'small'
    run.go()
    assert run.ended
    assert len(changes(run)) == 1


@pytest.mark.parametrize('policy', ['hold', 'reject', 'continue', 'abort_job'])
def test_5_3_a_task_without_its_setup_gets_no_goal(policy: str) -> None:
    """The change was skipped; whatever the policy says, a person has to look."""
    text = SMALL.replace('setup:', f'on_failure: {policy}, retries: 2, setup:')
    text = text.replace('@a3', '@a3, runs_for: all')
    run = gripped(a2='TASK_C#1=abort').run(text)
    run.answer('skip')
    run.go()
    assert run.starts('work') == []
    (hold,) = run.state.holds.values()
    assert (hold.task, hold.reason) == ('work', 'setup_missing')
    assert hold.message == 'gripper of a2 is not known; the task needs small'
    assert hold.answers == ('change', 'mark_done', 'skip', 'reject', 'abort_job')


def held_without_setup() -> VirtualRun:
    run = gripped(a2='TASK_C#1=abort').run(SMALL, 2)
    run.answer('skip')
    return run.go()


def test_5_3_the_answer_change_changes_it_and_goes_on() -> None:
    run = held_without_setup()
    assert run.answer('change').accepted
    run.go()
    assert run.ended
    assert run.counts()['packed'] == 2
    assert [value for _, _, value in changes(run)] == ['small', 'small']
    assert run.starts('work')[0] == run.times('task.succeeded', task='a2.gripper.small')[0]


def test_5_3_answered_change_starts_despite_earlier_jobs() -> None:
    """Section 3 has not finished J, whose item waits for the belt behind the held one."""
    line = Line(keys={'arm': GRIPPER})
    text = with_section(2, '- {id: work, @arm, setup: {gripper: small}}')
    run = line.begin(text, 1)
    run.submit('K', line.script(text), 2)
    run.go(until=run.now + 8.0)
    run.service('arm', out=True)
    run.service('arm', out=False)
    run.go()
    (hold,) = run.state.holds.values()
    assert hold.reason == 'setup_missing'
    run.answer('change')
    run.go()
    assert run.ended


def test_5_3_other_answers_begin_no_change() -> None:
    for answer, counted in (('mark_done', 'packed'), ('skip', 'packed'), ('reject', 'missing')):
        run = held_without_setup()
        assert run.answer(answer).accepted, answer
        run.go()
        assert len(changes(run)) == 1, counted


def test_5_3_a_change_that_fails_again_asks_again() -> None:
    run = gripped(a2='TASK_C#1=abort TASK_C#2=abort').run(SMALL)
    run.answer('skip')
    run.go()
    run.answer('change')
    run.go()
    (hold,) = run.state.holds.values()
    assert (hold.task, hold.reason) == ('a2.gripper.small', 'aborted')
    run.answer('skip')
    run.go()
    (hold,) = run.state.holds.values()
    assert (hold.task, hold.reason) == ('work', 'setup_missing')


def test_5_3_no_change_for_a_job_that_is_aborted() -> None:
    text = SMALL.replace('setup:', 'runs_for: all, setup:')
    run = gripped(a2='TASK_C#1=abort').run(text)
    run.answer('skip')
    run.go()
    assert run.control('abort', 'J').accepted
    (hold,) = run.state.holds.values()
    assert hold.answers == ('mark_done', 'skip')
    assert 'no change or abort_job: the job is being aborted' in hold.answers_why


def test_5_3_a_setup_is_unknown_after_stopped() -> None:
    run = gripped().begin(SMALL, 3)
    run.go(until=5.0)
    assert known(run.state, 'a2', 'gripper') == 'small'
    stopped_and_started(run)
    assert known(run.state, 'a2', 'gripper') is None
    run.go()
    (hold,) = run.state.holds.values()
    assert hold.reason == 'setup_missing'
    run.answer('change')
    run.go()
    assert run.ended


def test_5_3_stop_repeats_setup_of_unreached_component() -> None:
    run = gripped(seconds={'a1': 5.0}).begin(SMALL, 3)
    run.go(until=2.0)
    assert known(run.state, 'a2', 'gripper') == 'small'
    stopped_and_started(run)
    run.go()
    assert run.ended
    assert not run.all('hold.raised')
    assert len(changes(run)) == 2


def test_5_3_a_setup_is_unknown_after_out_of_service() -> None:
    run = gripped(seconds={'a1': 5.0}).begin(SMALL, 1)
    run.go(until=2.0)
    run.service('a2', out=True)
    assert known(run.state, 'a2', 'gripper') is None
    run.service('a2', out=False)
    run.go()
    assert run.ended
    assert len(changes(run)) == 2


def test_5_3_setup_is_unknown_during_change() -> None:
    run = gripped().begin(BOTH, 1)
    run.go(until=4.5)
    assert run.order('task.started')[-1] == 'to_large'
    assert known(run.state, 'a2', 'gripper') is None


def test_5_3_the_set_up_state_is_told() -> None:
    run = gripped().begin(SMALL)
    run.go(until=0.5)
    shown = {part.name: part for part in run.sim.status().components if part.setups}
    assert [(name, setup_words(part)) for name, part in shown.items()] == [
        ('a2', 'gripper not known')
    ]
    run.go()
    lines = list(status_lines(run.sim.status(), None))
    assert '  setup of a2: gripper small' in lines


def test_5_3_restarted_controller_makes_setup_unknown() -> None:
    run = gripped(seconds={'a1': 9.0}, a2='#1=abort #2=die:1').begin(SMALL, 1)
    run.go(until=1.5)
    run.answer('mark_done')
    assert known(run.state, 'a2', 'gripper') == 'small'
    run.go()
    (hold,) = run.state.holds.values()
    assert hold.reason == 'server_lost'
    assert run.all('component.setup_lost', component='a2')
    assert known(run.state, 'a2', 'gripper') is None
    run.answer('retry')
    run.go()
    (hold,) = run.state.holds.values()
    assert (hold.reason, run.starts('work')) == ('setup_missing', [run.starts('work')[0]])


# --- setups that a state topic tells (5.3.9) ----------------------------------------------------

READ = GRIPPER.replace('special_argument_1}', 'special_argument_1, reads: value}') + (
    ', state: {topic: /a2/state, type: diagnostic_msgs/msg/KeyValue, field: key, ready: [READY]}'
)


def reading(seconds: Mapping[str, float] | None = None, **faults: str) -> Line:
    return Line(keys={'a2': READ}, seconds=seconds, faults=faults)


def by_hand(run: VirtualRun, value: str) -> None:
    """Let somebody change the gripper by hand, which its topic tells."""
    run.sim.gateway.set_up('a2', 'gripper', value)
    run.sim.orchestrator.settle()


def test_5_3_setup_reported_by_topic_needs_no_change() -> None:
    line = reading()
    run = VirtualRun(line.cell, line.types)
    run.sim.gateway.set_up('a2', 'gripper', 'small')
    run.submit('J', line.script(SMALL), 1)
    run.go()
    assert run.ended
    assert changes(run) == []
    assert run.all('task.skipped', task='a2.gripper.small')[0]['reason'] == 'set up'


def test_5_3_the_topic_tells_what_a_change_has_set() -> None:
    run = reading().run(SMALL)
    assert run.ended
    assert [record.get('value', '') for record in run.all('component.setup_read')] == ['', 'small']
    assert known(run.state, 'a2', 'gripper') == 'small'


def test_5_3_stop_and_out_of_service_keep_reported_setup() -> None:
    run = reading().begin(SMALL, 3)
    run.go(until=5.0)
    stopped_and_started(run)
    run.service('a2', out=True)
    run.service('a2', out=False)
    assert known(run.state, 'a2', 'gripper') == 'small'
    run.go()
    assert run.ended
    assert len(changes(run)) == 1


def test_5_3_what_the_topic_tells_counts_before_the_change() -> None:
    run = reading(a2='TASK_C#1=abort').run(SMALL)
    run.answer('mark_done')
    by_hand(run, 'large')
    run.go()
    (hold,) = run.state.holds.values()
    assert (hold.task, hold.reason) == ('work', 'setup_missing')
    assert hold.message == 'gripper of a2 is large; the task needs small'
    run.answer('change')
    run.go()
    assert run.ended
    assert known(run.state, 'a2', 'gripper') == 'small'


def test_5_3_task_waits_five_seconds_for_setup_topic() -> None:
    run = reading(a2='TASK_C#1=abort').run(SMALL)
    run.answer('mark_done')
    run.go(until=run.now + 5.0)
    (wait,) = [part_wait.wait for part_wait in run.sim.waits() if 'tell' in part_wait.wait.reason]
    assert wait.reason == (
        'waiting for /a2/state to tell gripper small; nothing is published there'
    )
    assert not run.state.holds
    by_hand(run, 'small')
    run.go()
    assert run.ended
    assert not run.all('task.failed', task='work')


def test_5_3_after_five_seconds_the_task_is_held() -> None:
    run = reading(a2='TASK_C#1=abort').run(SMALL)
    run.answer('mark_done')
    run.go()
    (failed,) = run.all('task.failed', task='work')
    assert failed['time'] == run.times('belt.indexed')[0] + 5.0
    (hold,) = run.state.holds.values()
    assert hold.message == 'gripper of a2 is not known; the task needs small'


def test_5_3_unexpected_setup_is_changed_before_job_begins() -> None:
    run = reading(seconds={'a1': 9.0}).begin(SMALL)
    run.go(until=2.0)
    assert len(changes(run)) == 1
    by_hand(run, 'medium')
    run.go()
    assert run.ended
    assert not run.all('hold.raised')
    assert [value for _, _, value in changes(run)] == ['small', 'small']


def test_5_3_topic_may_report_change_later() -> None:
    run = reading(seconds={'a1': 9.0}, a2='TASK_C#1=abort').begin(SMALL)
    run.go(until=2.0)
    run.answer('mark_done')
    by_hand(run, 'medium')
    run.go(until=4.0)
    by_hand(run, 'small')
    run.go()
    assert run.ended
    assert len(changes(run)) == 1, 'it is not changed again'


def test_5_3_status_shows_setup_made_by_hand() -> None:
    run = reading(seconds={'a1': 9.0}).begin(SMALL)
    by_hand(run, 'medium')
    (shown,) = [component for component in run.sim.status().components if component.setups]
    assert setup_words(shown) == 'gripper medium'


def test_5_3_expected_ends_know_what_the_topic_tells() -> None:
    line = reading()
    run = VirtualRun(line.cell, line.types)
    run.sim.gateway.set_up('a2', 'gripper', 'large')
    run.submit('J', line.script(LARGE), 2)
    run.submit('K', line.script(SMALL), 2)
    run.go(until=1.0)
    plain = json.loads(json.dumps(state_to_plain(run.state)))
    ends = expected_ends(line.cell, line.types, plain, {}, run.now)
    run.go()
    assert [value for _, _, value in changes(run)] == ['small']
    real = {job: run.times('job.completed', job=job)[0] for job in 'JK'}
    assert ends == pytest.approx(real)


def test_5_3_silent_topic_makes_reported_setup_unknown() -> None:
    """Its controller dies, and the one that comes tells what it is set up for."""
    run = reading(seconds={'a1': 9.0}, a2='#2=die:1').begin(SMALL)
    run.go()
    (hold,) = run.state.holds.values()
    assert hold.reason == 'server_lost'
    assert not run.all('component.setup_lost')
    run.answer('retry')
    run.go()
    assert run.ended
    assert len(changes(run)) == 1


MISTAKES = {
    'not asked for back': (
        BOTH.replace(
            '    - {id: to_small, @a2.TASK_C, args: {special_argument_1: small}, runs_for: all}\n',
            '',
        ),
        '`two` leaves gripper large, but `one` asks for small',
    ),
    'other value': (
        BOTH.replace(
            '- {id: to_large, @a2.TASK_C, args: {special_argument_1: large}, runs_for: all}', ''
        ),
        '`two` asks for gripper large, but it is small there (`one`)',
    ),
    'side by side': (
        SMALL.replace('a2', 'arm').replace('@a3', '@arm, setup: {gripper: large}'),
        '`pack` works with gripper large, and `work` in section 2 with small',
    ),
    'not for all': (
        BOTH.replace(', runs_for: all', '', 1),
        '`to_large` changes a setup, so it must run for every item',
    ),
}


@pytest.mark.parametrize('case', MISTAKES)
def test_5_3_a_script_that_would_be_held_is_refused(case: str) -> None:
    text, expected = MISTAKES[case]
    with pytest.raises(Refused) as refused:
        gripped('arm' if 'arm' in text else 'a2').script(text)
    assert expected in str(refused.value)
