"""A status in words, as `status` and `watch` use them."""

from __future__ import annotations

from datetime import datetime
from typing import Any

import pytest
from fakes import statuses

from bt_orchestrator.model.packml import VERBS, PackmlState, possible_in
from bt_orchestrator.screen import words
from bt_orchestrator.screen.advice import Shell, hold_advice, next_choices

NODE = Shell()


def test_a_whole_status() -> None:
    status = statuses.status(
        state='Held',
        stop_reason='own_fault',
        stop_message='hold 1: work, aborted',
        holds=[statuses.hold(message='gripper open')],
        components=[statuses.component('worker', available=False)],
        initialization_waiting=['waiting for initialization home'],
    )
    assert list(words.status_lines(status, NODE)) == [
        'cell small_cell: Held for 12.0 s, belt at rest, seq 7',
        '  stands still: own_fault, hold 1: work, aborted',
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
        ({'state': 'Stopped'}, ['reset --reason "WHY"   gets the cell ready to start']),
        (
            {'state': 'Aborted'},
            [
                'clear --as-shown 7 --reason "WHY"   if the belt is as shown here',
                'clear --belt 1=ITEM,2=empty --reason "WHY"   else: every slot as it really is',
            ],
        ),
        (
            {'state': 'Stopped', 'jobs': []},
            [
                'submit ORDER.yaml   gives it a work order',
                'reset --reason "WHY"   gets the cell ready to start',
            ],
        ),
        (
            {'state': 'Stopped', 'jobs': [], 'waits_for': 'reset and start'},
            ['reset --reason "WHY"   gets the cell ready to start'],
        ),
        ({'state': 'Idle'}, ['start --reason "WHY"   lets the cell begin to work']),
        ({'state': 'Idle', 'jobs': []}, ['submit ORDER.yaml   gives it a work order']),
        ({'state': 'Complete', 'jobs': []}, ['submit ORDER.yaml   gives it a work order']),
        ({'state': 'Complete'}, ['reset --reason "WHY"   gets the cell ready to start']),
        ({'state': 'Execute'}, []),
        ({'state': 'Stopped', 'holds': [statuses.hold()]}, []),
    ],
)
def test_what_can_be_typed_next(about: dict[str, Any], lines: list[str]) -> None:
    said = list(words.status_lines(statuses.status(**about), NODE))
    begin = '  next: bt-orchestrator '
    assert [line.removeprefix(begin) for line in said if line.startswith(begin)] == lines


def test_every_state_in_which_a_cell_waits_for_somebody_names_commands_it_takes() -> None:
    for packml in PackmlState:
        for choice in next_choices(statuses.status(state=packml.value)):
            verbs = [VERBS[cause] for cause in possible_in(packml)]
            assert choice.name in [*verbs, 'submit'], packml


def stopped(**fields: Any) -> Any:
    usual = {'stopped_by': 'Ann', 'stopped_with': 'stop', 'stopped_why': 'end\nof shift'}
    return statuses.status(**{**usual, 'waits_for': 'reset and start', **fields})


def test_who_stopped_the_cell_is_said_with_what_lets_it_work_again() -> None:
    words_of = list(words.status_lines(stopped(stopped_at=statuses.stamp(3600)), NODE))
    at = datetime.fromtimestamp(3600).strftime('%H:%M:%S')
    said = f'Ann said stop at {at}: end of shift; orders wait for reset and start'
    assert words_of[1] == f'  {said}'
    soon = stopped(stopped_with='stop_after_job', waits_for='', stopped_why='')
    assert words.stopped(soon) == 'Ann said stop after job; orders wait for a start after that'
    unknown = stopped(stopped_by='', stopped_why='')
    assert words.stopped(unknown) == 'an operator said stop; orders wait for reset and start'


def test_a_stop_to_come_is_said() -> None:
    status = statuses.status(stop_after='job')
    assert '  the cell stops after the current job' in list(words.status_lines(status, NODE))


@pytest.mark.parametrize(
    ('later_s', 'text'),
    [(40, 'in 40 s'), (180, 'in 3 min'), (7200, 'in 2.0 h'), (0, 'any moment')],
)
def test_the_expected_finish_is_a_time_of_day_and_how_long_that_is(
    later_s: int, text: str
) -> None:
    clock = datetime.fromtimestamp(statuses.NOW_S + later_s).strftime('%H:%M:%S')
    job = statuses.job(expected_end_s=later_s)
    lines = list(words.status_lines(statuses.status(jobs=[job]), NODE))

    assert lines[1].endswith(f'0 of 10 packed, expected finish {clock} ({text})')


def test_further_attempts_and_bad_counts_are_said() -> None:
    assert words.task(statuses.task('4.1', attempt=3)) == '4.1 TASK_A, attempt 3 at /4.1/task'
    bad = statuses.job(packed=3, rejected=2, missing=1)
    assert words.job_counts(bad) == '3 of 10 packed, 2 rejected, 1 missing'


def test_an_id_that_holds_the_name_stands_alone() -> None:
    task = statuses.task('TASK_A')
    assert words.task(task) == 'TASK_A at /TASK_A/task'


def test_what_is_wrong_with_an_item_is_said() -> None:
    bad = statuses.section(2, 'WO-1/2', rejected=True, nonconforming=['weigh'], waiting=['w'])
    assert words.fate(statuses.section(1, 'WO-1/2')) == ''
    lines = list(words.status_lines(statuses.status(sections=[bad]), NODE))
    assert '  section 2   WO-1/2         rejected, nonconforming (weigh); w' in lines


def test_an_empty_position_stands_in_brackets() -> None:
    assert words.slot(statuses.section(1, 'WO-1/2', empty_position=True)) == '(WO-1/2)'


@pytest.mark.parametrize(
    ('component', 'said'),
    [
        (statuses.component('arm'), ''),
        (statuses.component('arm', available=False), 'arm: no action server at /arm/task'),
        (statuses.component('arm', ready=False), 'arm: not ready, no state yet'),
        (
            statuses.component('arm', ready=False, state='DOOR_OPEN'),
            'arm: not ready, its state is DOOR_OPEN',
        ),
    ],
)
def test_why_a_component_can_be_sent_nothing(component: object, said: str) -> None:
    assert words.trouble(component) == said


@pytest.mark.parametrize(
    ('about', 'advice'),
    [
        (
            {'answers': ['remove_item'], 'task': ''},
            ['bt-orchestrator remove-item WO-1/1 --reason "WHY"'],
        ),
        (
            {'answers': ['resume'], 'task': '', 'item': '', 'section': 0},
            ['bt-orchestrator resume --hold 1 --reason "WHY"'],
        ),
        ({'answers': ['retry']}, ['bt-orchestrator answer 1 retry --reason "WHY"']),
        ({'answers': []}, []),
    ],
)
def test_what_an_operator_types_about_a_hold(about: dict[str, Any], advice: list[str]) -> None:
    assert hold_advice(statuses.hold(**about), NODE) == advice


def test_a_node_of_another_name_stands_in_the_command() -> None:
    (command, _) = hold_advice(statuses.hold(), Shell('/left/bt_orchestrator'))
    assert command.endswith(' --node /left/bt_orchestrator')


def test_a_hold_of_the_whole_cell() -> None:
    paused = statuses.hold(
        task='',
        item='',
        job='',
        section=0,
        attempt=0,
        reason='paused',
        message='Ada: lunch',
    )
    assert words.hold_text(paused) == 'hold 1: paused (Ada: lunch)'


def test_what_a_controller_says_cannot_steer_the_terminal() -> None:
    nasty = statuses.hold(message='bad\n\x1b[2Jend\r\t\x07')
    assert words.hold_text(nasty).endswith('aborted (bad \ufffd[2Jend \ufffd)')


@pytest.mark.parametrize(
    ('seconds', 'said'),
    [(0.04, '0.0 s'), (99.9, '99.9 s'), (100, '1:40'), (3599, '59:59'), (359999, '99:59:59')],
)
def test_durations(seconds: float, said: str) -> None:
    assert words.duration(seconds) == said
