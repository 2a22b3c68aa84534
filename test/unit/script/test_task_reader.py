"""One task of a script: keys, ids, actions, constants."""

from __future__ import annotations

import pytest
from fakes.action_types import FakeActionTypes
from fakes.mistake_tables import table
from fakes.mistake_texts import INITIALIZATION, TASK
from fakes.script_texts import LINE, line, mistakes, script

from bt_orchestrator.model.cell import OnFailure
from bt_orchestrator.model.script import RunsFor
from bt_orchestrator.script.cell_file import parse_cell
from bt_orchestrator.script.script_file import parse_script


@pytest.mark.parametrize(('options', 'expected'), table('task_options'))
def test_options(options: str, expected: list[str]) -> None:
    assert mistakes(lambda: line(TASK.format(options))) == expected


@pytest.mark.parametrize(('options', 'expected'), table('initialization_options'))
def test_options_of_initialization(options: str, expected: list[str]) -> None:
    assert mistakes(lambda: line(INITIALIZATION.format(options))) == expected


@pytest.mark.parametrize(('text', 'expected'), table('task_names'))
def test_what_a_task_names(text: str, expected: list[str]) -> None:
    assert mistakes(lambda: line(text)) == expected


def test_a_task_is_read_with_all_its_options() -> None:
    read = line(
        '  2: [{id: look, task: RUN, action: /camera/task, requires_conveyor: false, retries: 2,\n'
        '    retry_delay: 1, timeout: 5, repeatable: true, runs_for: all,\n'
        '    on_failure: abort_job}]\n'
    )
    task = read.tasks['look']
    assert (task.name, task.action, task.component) == ('RUN', '/camera/task', 'camera')
    assert (task.retries, task.retry_delay_s, task.timeout_s) == (2, 1.0, 5.0)
    assert (task.requires_conveyor, task.repeatable, task.qty_change) == (False, True, 0)
    assert (task.runs_for, task.on_failure) == (RunsFor.ALL, OnFailure.ABORT_JOB)


def test_an_initialization_task_is_read_with_its_options() -> None:
    read = line('initialization: [{id: a, task: RUN, action: /lamp/task, once: true}]\n')
    assert (read.tasks['a'].once, read.tasks['place'].once) == (True, False)


@pytest.mark.parametrize(
    ('task', 'timeout_s'),
    [
        ('{task: RUN, action: /camera/task}', 300.0),
        ('{task: RUN, action: /camera/task, timeout: none}', None),
        ('{task: RUN, action: /lamp/task}', None),
        ('{task: RUN, action: /lamp/task, timeout: 7}', 7.0),
    ],
)
def test_the_timeout_is_the_tasks_else_the_components(task: str, timeout_s: float | None) -> None:
    assert line(f'  2: [{task}]\n').tasks['2.1'].timeout_s == timeout_s


@pytest.mark.parametrize(
    ('option', 'policy'),
    [
        ('continue_if_fail: true', OnFailure.CONTINUE),
        ('continue_if_fail: false', OnFailure.HOLD),
        ('on_failure: continue', OnFailure.CONTINUE),
        ('retries: 0', OnFailure.HOLD),
    ],
)
def test_continue_if_fail_is_a_policy(option: str, policy: OnFailure) -> None:
    assert line(TASK.format(f', {option}')).tasks['2.1'].on_failure is policy


def test_task_without_task_field_is_labelled_by_type() -> None:
    assert line('  2: [{action: /cart/drive}]\n').tasks['2.1'].name == 'DriveTo'


def test_task_on_belt_without_task_field_is_refused() -> None:
    belt = parse_cell(
        'cell: c\n'
        'conveyor: {sections: 1, action: /belt, type: plain_interfaces/action/Index}\n'
        'components: {lamp: {action: /lamp/task, type: test_interfaces/action/Rich}}\n',
        'cell.yaml',
        FakeActionTypes(),
    )
    text = 'script: a\ninitialization: [{task: GO, action: /belt}]\nsections: {1: [\n'
    text += '  {id: in, task: RUN, action: /lamp/task, qty_change: 1},\n'
    text += '  {id: out, task: RUN, action: /lamp/task, qty_change: -1}]}\n'
    findings = mistakes(lambda: parse_script(text, 's.yaml', belt, FakeActionTypes()))
    assert [finding.split(':')[:2] for finding in findings] == [['2', '25']]
    assert 'a task cannot move the belt' in findings[0]


def test_missing_type_is_reported_where_it_is_used() -> None:
    cell_text = (
        'cell: c\n'
        'conveyor: {sections: 1, action: /belt, type: plain_interfaces/action/Index}\n'
        'components: {lamp: {action: /lamp/task, type: test_interfaces/action/Rich}}\n'
    )
    belt = parse_cell(cell_text, 'cell.yaml', FakeActionTypes())
    text = 'script: a\nsections: {1: [\n'
    text += '  {id: in, task: RUN, action: /lamp/task, qty_change: 1, args: {x: 1}},\n'
    text += '  {id: out, task: RUN, action: /lamp/task, qty_change: -1}]}\n'
    assert mistakes(
        lambda: parse_script(text, 's.yaml', belt, FakeActionTypes(without='test_interfaces'))
    ) == [
        (
            '3:31: the package test_interfaces is not installed; '
            'install test_interfaces and source its workspace'
        )
    ]


def test_a_misspelt_key_has_no_consequences() -> None:
    text = LINE.replace('qty_change: 1', 'qty_chnge: 1')
    assert mistakes(lambda: script(text)) == [
        '3:66: a task has no key `qty_chnge`; did you mean `qty_change`?'
    ]
