"""What the installed packages say about types; needs them, but no ROS context."""

from __future__ import annotations

import subprocess
import sys

import pytest

from bt_orchestrator.base.errors import UnknownActionType
from bt_orchestrator.model.action_type import FieldType
from bt_orchestrator.ros.types.action_types import InstalledActionTypes, message_type
from bt_orchestrator.ros.types.interface_classes import message_class

pytestmark = pytest.mark.every_distro

TYPES = InstalledActionTypes()


def fields(type_name: str) -> dict[str, FieldType]:
    return dict(message_type(message_class(type_name), type_name).fields)


def test_goal_result_and_constants() -> None:
    component = TYPES.action('bt_orchestrator_interfaces/action/Component')
    assert component.name == 'bt_orchestrator_interfaces/action/Component'
    assert dict(component.constants) == {'PREPARE': 0, 'TASK_A': 1, 'TASK_B': 2, 'TASK_C': 3}
    assert {name: field.ros_name for name, field in component.goal.fields.items()} == {
        'task': 'uint8',
        'special_argument_1': 'string',
        'special_argument_2': 'float64',
    }
    assert [*component.result.fields] == ['task_result', 'item_present', 'measurement']
    assert component.has_task_field


def test_type_without_task_field_or_constants() -> None:
    fibonacci = TYPES.action('test_msgs/action/Fibonacci')
    assert not fibonacci.has_task_field
    assert dict(fibonacci.constants) == {}
    assert fibonacci.result.fields['sequence'].is_array


def test_defaults_of_fields_are_no_constants() -> None:
    assert dict(TYPES.action('test_msgs/action/NestedMessage').constants) == {}


def test_nested_messages() -> None:
    goal = TYPES.action('test_msgs/action/NestedMessage').goal
    nested = goal.fields['nested_different_pkg']
    assert (nested.kind, nested.ros_name) == ('message', 'builtin_interfaces/msg/Time')
    assert nested.message is not None
    assert nested.message.fields['nanosec'].maximum == 2**32 - 1


@pytest.mark.parametrize(
    ('name', 'kind', 'ros_name', 'minimum', 'maximum'),
    [
        ('bool_value', 'bool', 'bool', None, None),
        ('byte_value', 'bytes', 'byte', None, None),
        ('float32_value', 'float', 'float32', None, None),
        ('float64_value', 'float', 'float64', None, None),
        ('int8_value', 'int', 'int8', -128, 127),
        ('uint8_value', 'int', 'uint8', 0, 255),
        ('int64_value', 'int', 'int64', -(2**63), 2**63 - 1),
        ('uint64_value', 'int', 'uint64', 0, 2**64 - 1),
    ],
)
def test_basic_types(
    name: str, kind: str, ros_name: str, minimum: int | None, maximum: int | None
) -> None:
    field = fields('test_msgs/msg/BasicTypes')[name]
    assert (field.kind, field.ros_name) == (kind, ros_name)
    assert (field.minimum, field.maximum) == (minimum, maximum)
    assert not field.is_array


def test_strings() -> None:
    strings = fields('test_msgs/msg/Strings')
    assert strings['string_value'] == FieldType('str', 'string')
    bounded = strings['bounded_string_value']
    assert bounded == FieldType('str', 'string<=22', string_maximum=22)
    assert fields('test_msgs/msg/WStrings')['wstring_value'] == FieldType('str', 'wstring')


@pytest.mark.parametrize(
    ('type_name', 'ros_name', 'length', 'longest'),
    [
        ('test_msgs/msg/Arrays', 'int32[3]', 3, None),
        ('test_msgs/msg/BoundedSequences', 'int32[<=3]', None, 3),
        ('test_msgs/msg/UnboundedSequences', 'int32[]', None, None),
    ],
)
def test_arrays(type_name: str, ros_name: str, length: int | None, longest: int | None) -> None:
    field = fields(type_name)['int32_values']
    assert (field.ros_name, field.is_array) == (ros_name, True)
    assert (field.array_length, field.array_maximum) == (length, longest)
    assert field.maximum == 2**31 - 1


def test_arrays_of_messages() -> None:
    field = fields('test_msgs/msg/Arrays')['basic_types_values']
    assert field.ros_name == 'test_msgs/msg/BasicTypes[3]'
    assert field.message is not None


@pytest.mark.parametrize(
    ('name', 'what', 'hint'),
    [
        ('Conveyor', "'Conveyor' is not a type name", 'package/action/Name'),
        ('no_such/action/Move', 'the package no_such is not installed', 'source its workspace'),
        ('std_msgs/action/String', 'the package std_msgs has no action types', 'another package'),
        ('std_msgs/msg/String', 'std_msgs/msg/String is a message, not an action', '/action/'),
        ('std_srvs/srv/Empty', 'std_srvs/srv/Empty is a service, not an action', '/action/'),
        (
            'test_msgs/action/BasicTypes',
            'test_msgs/msg/BasicTypes is a message, not an action',
            'Fibonacci',
        ),
        (
            'test_msgs/action/Fibonaci',
            'the package test_msgs has no action type Fibonaci',
            'did you mean `Fibonacci`?',
        ),
        (
            'test_msgs/action/Qqq',
            'the package test_msgs has no action type Qqq',
            'it has `Fibonacci`, `NestedMessage`',
        ),
    ],
)
def test_unknown_action(name: str, what: str, hint: str) -> None:
    with pytest.raises(UnknownActionType) as refused:
        TYPES.action(name)
    assert refused.value.type_name == name
    assert refused.value.what == what
    assert hint in refused.value.hint


@pytest.mark.parametrize(('field', 'ros_name'), [('frame_id', 'string'), ('stamp.sec', 'int32')])
def test_message_field(field: str, ros_name: str) -> None:
    assert TYPES.message_field('std_msgs/msg/Header', field) == ros_name


@pytest.mark.parametrize(
    ('type_name', 'field', 'what', 'hint'),
    [
        ('std_msgs/msg/String', 'dat', 'has no field `dat`', 'did you mean `data`?'),
        ('std_msgs/msg/String', 'data.x', 'nothing is inside `data`', 'one value'),
        ('std_msgs/msg/Header', 'stamp.secs', 'has no field `stamp.secs`', '`sec`'),
        ('std_msgs/msg/Sring', 'data', 'has no msg type Sring', '`String`'),
        ('test_msgs/action/Fibonacci', 'order', 'is an action, not a message', '/msg/'),
    ],
)
def test_unknown_message_field(type_name: str, field: str, what: str, hint: str) -> None:
    with pytest.raises(UnknownActionType) as refused:
        TYPES.message_field(type_name, field)
    assert what in refused.value.what
    assert hint in refused.value.hint


def test_needs_no_client_library() -> None:
    program = (
        'import sys\n'
        'from bt_orchestrator.ros.types.action_types import InstalledActionTypes\n'
        'InstalledActionTypes().action("test_msgs/action/NestedMessage")\n'
        'InstalledActionTypes().message_field("std_msgs/msg/String", "data")\n'
        'print("rclpy" in sys.modules)\n'
    )
    done = subprocess.run(
        [sys.executable, '-c', program], check=True, stdout=subprocess.PIPE, text=True
    )
    assert done.stdout == 'False\n'
