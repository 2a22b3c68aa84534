"""Goal arguments against the goal's fields."""

from __future__ import annotations

import pytest
from fakes.action_types import POSE_FIELD, UINT8, array
from fakes.mistake_tables import table
from fakes.mistake_texts import ARGUMENTS
from fakes.script_texts import line, mistakes

from bt_orchestrator.script.checks.arguments import member_type


@pytest.mark.parametrize(('arguments', 'expected'), table('arguments'))
def test_arguments(arguments: str, expected: list[str]) -> None:
    assert mistakes(lambda: line(ARGUMENTS.format(arguments))) == expected


def test_arguments_are_plain_values() -> None:
    read = line(ARGUMENTS.format('ratio: 1, names: [a], pose: {position: {x: 2}}, few: [1, 2]'))
    args = read.tasks['2.1'].args
    assert args == {
        'ratio': 1.0,
        'names': ['a'],
        'pose': {'position': {'x': 2.0}},
        'few': [1, 2],
    }
    assert isinstance(args['ratio'], float)


def test_goal_without_task_field_refuses_task_argument() -> None:
    findings = mistakes(lambda: line('  2: [{action: /cart/drive, args: {task: 1, speed: 2}}]\n'))
    assert findings == [
        (
            '5:36: the goal of nav_interfaces/action/DriveTo has no field `task`; '
            'its fields are `place`, `speed`'
        )
    ]


def test_arguments_are_a_mapping() -> None:
    assert mistakes(lambda: line('  2: [{action: /cart/drive, args: [1]}]\n')) == [
        (
            '5:35: `args` must be a mapping, not a list; '
            'write for instance `args: {label: "${params.lot}"}`'
        )
    ]


def test_the_members_of_an_array_have_its_range() -> None:
    few = member_type(array(UINT8, longest=2))
    assert (few.ros_name, few.maximum, few.is_array) == ('uint8', 255, False)
    assert member_type(array(POSE_FIELD)).message is POSE_FIELD.message
