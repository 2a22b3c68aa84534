"""A status in words, as `status` and `watch` use them."""

from __future__ import annotations

from dataclasses import replace
from datetime import datetime
from typing import Any

import pytest
from fakes import statuses

from bt_orchestrator.model.by import Role
from bt_orchestrator.model.jobs.isa95 import JobWord
from bt_orchestrator.model.jobs.order import MadeAnew
from bt_orchestrator.model.packml import VERBS, PackmlState, possible_in
from bt_orchestrator.model.status import CellStatus, ComponentStatus
from bt_orchestrator.model.status_words import job_count_words
from bt_orchestrator.model.stop_reason import StopReason, Wish
from bt_orchestrator.view.screen import words
from bt_orchestrator.view.screen.advice import Shell, hold_advice, next_choices
from bt_orchestrator.view.screen.view import cell_view

NODE = Shell()


def test_a_whole_status() -> None:
    status = statuses.status(
        state=PackmlState.HELD,
        stop_reason=StopReason.OWN_FAULT,
        stop_message='hold 1 (work: aborted)',
        holds=[statuses.hold(message='gripper open')],
        components=[statuses.component('worker', available=False)],
        initialization=[statuses.wait('waiting for initialization home')],
    )
    assert list(words.status_lines(status, NODE)) == [
        'cell small_cell: Held for 12.0 s, belt at rest, seq 7',
        '  stands still: own_fault, hold 1 (work: aborted)',
        '  WO-1 (small): Running, 0 of 10 packed',
        '  initialization  waiting for initialization home',
        '  section 1   -              waiting for the belt to move',
        '  section 2   WO-1/1         work TASK_A at /work/task',
        '  worker: no action server at /worker/task',
        '  flag clear: 0 of 1',
        (
            '  hold 1: section 2, work (TASK_A) of WO-1/1 at arm (/arm/task), attempt 1 of 2: '
            'aborted (gripper open)'
        ),
        '    bt-orchestrator answer 1 retry --reason "WHY"',
        '    or skip in place of retry',
    ]


@pytest.mark.parametrize(
    ('about', 'lines'),
    [
        (
            {'state': PackmlState.STOPPED},
            ['cell reset --reason "WHY"   gets the cell ready to start'],
        ),
        (
            {'state': PackmlState.ABORTED},
            [
                'cell clear --as-shown 7 --reason "WHY"   if the belt is as shown here',
                (
                    'cell clear --belt 1=ITEM,2=empty --reason "WHY"   '
                    'else: every slot as it really is'
                ),
            ],
        ),
        (
            {'state': PackmlState.STOPPED, 'jobs': []},
            [
                'submit ORDER.yaml   gives it a work order',
                'cell reset --reason "WHY"   gets the cell ready to start',
            ],
        ),
        (
            {'state': PackmlState.STOPPED, 'jobs': [], 'waits_for': 'reset and start'},
            ['cell reset --reason "WHY"   gets the cell ready to start'],
        ),
        ({'state': PackmlState.IDLE}, ['cell start --reason "WHY"   lets the cell begin to work']),
        ({'state': PackmlState.IDLE, 'jobs': []}, ['submit ORDER.yaml   gives it a work order']),
        (
            {'state': PackmlState.COMPLETE, 'jobs': []},
            ['submit ORDER.yaml   gives it a work order'],
        ),
        (
            {'state': PackmlState.COMPLETE},
            ['cell reset --reason "WHY"   gets the cell ready to start'],
        ),
        ({'state': PackmlState.EXECUTE}, []),
        ({'state': PackmlState.STOPPED, 'holds': [statuses.hold()]}, []),
    ],
)
def test_what_can_be_typed_next(about: dict[str, Any], lines: list[str]) -> None:
    output = list(words.status_lines(statuses.status(**about), NODE))
    begin = '  next: bt-orchestrator '
    assert [line.removeprefix(begin) for line in output if line.startswith(begin)] == lines


def test_every_waiting_state_names_commands_it_accepts() -> None:
    for packml in PackmlState:
        for choice in next_choices(statuses.status(state=packml)):
            verbs = [VERBS[cause] for cause in possible_in(packml)]
            assert choice.name in [*verbs, 'submit'], packml


def stopped(
    command: str = 'stop', who: str = '', why: str = '', known: str = 'local user', **wish: float
) -> CellStatus:
    waits_for = 'reset and start' if command == 'stop' else ''
    return statuses.status(wish=Wish(command, who, why, known=known, **wish), waits_for=waits_for)


def test_stop_text_names_person_and_next_commands() -> None:
    status = stopped('stop', 'Ann', 'end\nof shift', time=3600.0)
    words_of = list(words.status_lines(status, NODE))
    at = datetime.fromtimestamp(3600).strftime('%H:%M:%S')
    sentence = f'Ann said stop at {at}: end of shift; orders wait for reset and start'
    assert words_of[1] == f'  {sentence}'
    soon = stopped('stop_after_job', 'Ann')
    assert words.stopped(soon) == 'Ann said stop after job; orders wait for a start after that'
    assert words.stopped(stopped()) == 'somebody said stop; orders wait for reset and start'
    claimed = words.stopped(stopped('stop', 'Ann', known='ros unauthenticated'))
    assert claimed.startswith('somebody who claims to be Ann said stop; ')


def test_a_stop_to_come_is_said() -> None:
    status = statuses.status(stop_after='job')
    assert '  the cell stops after the current job' in list(words.status_lines(status, NODE))


@pytest.mark.parametrize(
    ('later_s', 'text'),
    [(40, 'in 40 s'), (180, 'in 3 min'), (7200, 'in 2.0 h'), (0, 'any moment')],
)
def test_expected_finish_shows_time_and_remaining_duration(later_s: int, text: str) -> None:
    clock = datetime.fromtimestamp(statuses.NOW_S + later_s).strftime('%H:%M:%S')
    job = statuses.job(expected_end_s=later_s)
    lines = list(words.status_lines(statuses.status(jobs=[job]), NODE))

    assert lines[1].endswith(f'0 of 10 packed, expected finish {clock} ({text})')


def test_further_attempts_and_bad_counts_are_said() -> None:
    assert words.task(statuses.task('4.1', attempt=3)) == '4.1 TASK_A, attempt 3 at /4.1/task'
    again = replace(statuses.task('glue', attempt=2), round=1)
    assert words.task(again) == 'glue TASK_A, round 2, attempt 2 at /glue/task'
    bad = statuses.job(packed=3, rejected=2, missing=1)
    assert job_count_words(bad) == '3 of 10 packed, 2 rejected, 1 missing'


def test_an_id_that_holds_the_name_stands_alone() -> None:
    task = statuses.task('TASK_A')
    assert words.task(task) == 'TASK_A at /TASK_A/task'


def test_what_is_wrong_with_an_item_is_said() -> None:
    bad = statuses.section(2, 'WO-1/2', rejected=True, nonconforming=['weigh'], waiting=['w'])
    assert words.fate(statuses.item('WO-1/2')) == ''
    lines = list(words.status_lines(statuses.status(sections=[bad]), NODE))
    assert '  section 2   WO-1/2         rejected, nonconforming (weigh); w' in lines


def test_an_empty_position_stands_in_brackets() -> None:
    assert words.slot(statuses.item('WO-1/2', empty_position=True)) == '(WO-1/2)'


@pytest.mark.parametrize(
    ('component', 'message'),
    [
        (statuses.component('arm'), ''),
        (statuses.component('arm', available=False), 'arm: no action server at /arm/task'),
        (statuses.component('arm', ready=False), 'arm: not ready, no state yet'),
        (
            statuses.component('arm', ready=False, state='DOOR_OPEN'),
            'arm: not ready, its state is DOOR_OPEN',
        ),
        (
            statuses.component(
                'arm',
                available=False,
                ready=False,
                out_of_service='Ann: worn',
                out_of_service_since=7.0,
            ),
            'arm: out of service, Ann: worn',
        ),
    ],
)
def test_why_a_component_can_be_sent_nothing(component: ComponentStatus, message: str) -> None:
    assert words.trouble(component) == message


@pytest.mark.parametrize(
    ('about', 'advice'),
    [
        (
            {'answers': ('remove_item',), 'task': None},
            ['bt-orchestrator remove-item WO-1/1 --reason "WHY"'],
        ),
        (
            {'answers': ('resume',), 'task': None, 'item': None, 'section': None},
            ['bt-orchestrator cell resume --hold 1 --reason "WHY"'],
        ),
        ({'answers': ('retry',)}, ['bt-orchestrator answer 1 retry --reason "WHY"']),
        ({'answers': ()}, []),
    ],
)
def test_what_an_operator_types_about_a_hold(about: dict[str, Any], advice: list[str]) -> None:
    assert hold_advice(statuses.hold(**about), NODE) == advice


SIX = ('retry', 'mark_done', 'skip', 'reject', 'abort_job')


@pytest.mark.parametrize(
    ('role', 'answers', 'advice'),
    [
        (
            Role.OPERATE,
            SIX,
            [
                'bt-orchestrator answer 1 retry --reason "WHY"',
                'or mark_done, skip, reject in place of retry',
                'an engineer may also: abort_job',
            ],
        ),
        (
            Role.ENGINEER,
            SIX,
            [
                'bt-orchestrator answer 1 retry --reason "WHY"',
                'or mark_done, skip, reject, abort_job in place of retry',
            ],
        ),
        (
            Role.VIEW,
            SIX,
            [
                'an operator or an engineer may: retry, mark_done, skip, reject',
                'an engineer may: abort_job',
            ],
        ),
        (
            Role.OPERATE,
            ('abort_job', 'retry'),
            ['bt-orchestrator answer 1 retry --reason "WHY"', 'an engineer may also: abort_job'],
        ),
        (Role.OPERATE, ('remove_item',), ['an engineer may: remove_item']),
    ],
)
def test_7_1_reader_sees_answers_of_own_role(
    role: Role, answers: tuple[str, ...], advice: list[str]
) -> None:
    hold = statuses.hold(answers=answers)
    assert hold_advice(hold, NODE, role) == advice
    status = statuses.status(state=PackmlState.HELD, holds=[hold], unauthenticated_role=role)
    shown = list(words.status_lines(status, NODE))
    assert [line.strip() for line in shown if line.strip() in advice] == advice
    (row,) = cell_view(status, NODE).holds
    assert list(row.advice) == advice


def test_7_1_the_next_command_names_who_may_give_it() -> None:
    status = statuses.status(state=PackmlState.ABORTED, unauthenticated_role=Role.OPERATE)
    rows = [line.strip() for line in words.status_lines(status, NODE)]
    clear = 'bt-orchestrator cell clear --as-shown 7 --reason "WHY"   if the belt is as shown here'
    assert f'next: an engineer may: {clear}' in rows
    status = statuses.status(state=PackmlState.STOPPED, unauthenticated_role=Role.OPERATE)
    rows = [line.strip() for line in words.status_lines(status, NODE)]
    assert 'next: bt-orchestrator cell reset --reason "WHY"   gets the cell ready to start' in rows


def test_command_contains_name_of_other_node() -> None:
    (command, _) = hold_advice(statuses.hold(), Shell('/left/bt_orchestrator'))
    assert command.endswith(' --node /left/bt_orchestrator')


def test_a_hold_of_the_whole_cell() -> None:
    paused = statuses.hold(
        task=None,
        item=None,
        job=None,
        section=None,
        attempt=0,
        reason='paused',
        message='Ada: lunch',
    )
    assert words.hold_text(paused) == 'hold 1: paused (Ada: lunch)'


def test_what_a_controller_says_cannot_steer_the_terminal() -> None:
    nasty = statuses.hold(message='bad\n\x1b[2Jend\r\t\x07')
    assert words.hold_text(nasty).endswith('aborted (bad \ufffd[2Jend \ufffd)')


@pytest.mark.parametrize(
    ('seconds', 'message'),
    [(0.04, '0.0 s'), (99.9, '99.9 s'), (100, '1:40'), (3599, '59:59'), (359999, '99:59:59')],
)
def test_durations(seconds: float, message: str) -> None:
    assert words.duration(seconds) == message


def test_job_waiting_for_start_is_shown_everywhere() -> None:
    start = datetime(2036, 5, 18, 6).timestamp()
    job = statuses.job(state=JobWord.ALLOWED_TO_START, start=start, awaits_start=True, priority=2)
    status = statuses.status(jobs=[job])
    term = 'waits for its start 2036-05-18 06:00'
    assert words.job_terms(job) == f', priority 2, {term}'
    assert any(term in line for line in words.status_lines(status, NODE))
    assert cell_view(status, NODE).jobs[0].counts == f'0 of 10 packed, {term}'
    may_start = replace(job, awaits_start=False)
    assert words.job_terms(may_start) == ', priority 2, start 2036-05-18 06:00'


def test_job_with_unreleased_script_shows_release_command() -> None:
    state = JobWord.NOT_ALLOWED_TO_START
    queued = statuses.job(state=state, digest='0a1b', awaits_release=True, unavailable=('arm',))
    assert words.job_terms(queued) == ', its script is not released, needs arm, out of service'
    text = '\n'.join(words.status_lines(statuses.status(jobs=[queued]), NODE))
    assert 'an engineer releases it: bt-orchestrator release-script 0a1b --reason "WHY"' in text
    assert 'releases it' not in '\n'.join(words.status_lines(statuses.status(jobs=[queued]), None))


def test_job_lacking_component_shows_the_remedy() -> None:
    queued = statuses.job(state=JobWord.NOT_ALLOWED_TO_START, unavailable=('arm',))
    status = statuses.status(jobs=[queued])
    term = ', needs arm, out of service'
    assert words.job_terms(queued) == term
    assert cell_view(status, NODE).jobs[0].counts == f'0 of 10 packed{term}'
    assert not any('queue stop' in line for line in words.status_lines(status, NODE))
    running = statuses.job(unavailable=('arm', 'belt'), started_at=3.0)
    lines = list(words.status_lines(statuses.status(jobs=[running]), NODE))
    offered = f'stop it (job stop {running.id}) and queue the rest anew'
    assert any('needs arm and belt' in line and offered in line for line in lines)
    for more, way in (
        ({}, 'to make the rest without it now: job requeue WO-1'),
        ({'started': 10}, 'or aborts it (job abort WO-1)'),
        ({'ending': 'stopping'}, 'or aborts it (job abort WO-1)'),
    ):
        job = statuses.job(unavailable=('arm',), started_at=3.0, by_recipe=True, **more)
        text = '\n'.join(words.status_lines(statuses.status(jobs=[job]), NODE))
        assert f'{way}\n' in text


def test_remade_job_names_missing_components_and_pace() -> None:
    anew = MadeAnew(('arm', 'lid'), (), 4.0, 3.0)
    job = statuses.job(rest_of='WO-9', anew=anew, state=JobWord.ALLOWED_TO_START, position=1)
    term = ', rest of WO-9, made anew without arm and lid: 4.0 s per item (+33 %)'
    assert words.job_terms(job) == term
    for other, text in (
        (MadeAnew((), ('arm',), 3.0, 4.0), 'made anew with arm: 3.0 s per item (-25 %)'),
        (MadeAnew(('arm',), (), 3.0, 3.0), 'made anew without arm: 3.0 s per item'),
        (MadeAnew(('arm',)), 'made anew without arm'),
    ):
        assert words.job_terms(statuses.job(anew=other)) == f', {text}'
    assert words.job_terms(statuses.job(anew=anew, state=JobWord.ENDED)) == ''


def test_ending_job_is_marked_in_every_view() -> None:
    status = statuses.status(jobs=[statuses.job(ending='aborting', started_at=3.0, started=2)])
    assert any(': Running, aborting, 0 of 10' in line for line in words.status_lines(status, NODE))
    assert ', aborting' in cell_view(status, NODE).jobs[0].counts


def test_a_hold_says_why_answers_are_missing() -> None:
    why = 'no reject: the item is rejected already'
    lines = words.status_lines(statuses.status(holds=[statuses.hold(answers_why=why)]), NODE)
    assert list(lines)[-1].strip() == why
