"""Plain values into messages and back."""

from __future__ import annotations

import array
import math
from typing import Any

import numpy as np
import pytest
from rclpy.serialization import deserialize_message, serialize_message
from test_msgs import msg
from test_msgs.action import NestedMessage

from bt_orchestrator.ros.types.messages import InstalledInterfaces, field_value, fill, to_plain

pytestmark = pytest.mark.every_distro

ALL_KINDS = [
    msg.Arrays,
    msg.BasicTypes,
    msg.BoundedPlainSequences,
    msg.BoundedSequences,
    msg.Builtins,
    msg.Constants,
    msg.Defaults,
    msg.Empty,
    msg.MultiNested,
    msg.Nested,
    msg.Strings,
    msg.UnboundedSequences,
    msg.WStrings,
]


def filled(kind: Any, **fields: Any) -> Any:
    """Return a message as it arrives elsewhere."""
    message = kind()
    fill(message, fields)
    return deserialize_message(serialize_message(message), kind)


@pytest.mark.parametrize('kind', ALL_KINDS, ids=lambda kind: kind.__name__)
def test_there_and_back(kind: Any) -> None:
    fields = to_plain(kind())
    assert filled(kind, **fields) == kind()
    assert to_plain(filled(kind, **fields)) == fields


@pytest.mark.parametrize('kind', ALL_KINDS, ids=lambda kind: kind.__name__)
def test_plain_values_are_what_json_knows(kind: Any) -> None:
    def check(value: Any) -> None:
        if type(value) is dict:
            assert all(type(key) is str for key in value)
            value = [*value.values()]
        if type(value) is list:
            for member in value:
                check(member)
        else:
            assert type(value) in (bool, int, float, str)

    check(to_plain(kind()))


def test_values_of_every_basic_type() -> None:
    fields = {
        'bool_value': True,
        'byte_value': 200,
        'char_value': 65,
        'float32_value': 0.5,
        'float64_value': -1e300,
        'int8_value': -128,
        'uint8_value': 255,
        'int64_value': -(2**63),
        'uint64_value': 2**64 - 1,
    }
    assert to_plain(filled(msg.BasicTypes, **fields)).items() >= fields.items()


def test_whole_numbers_fit_floats() -> None:
    message = filled(msg.BasicTypes, float64_value=3)
    assert (message.float64_value, type(message.float64_value)) == (3.0, float)


def test_fields_not_named_keep_their_value() -> None:
    message = filled(NestedMessage.Goal, nested_field={'int32_value': 4})
    assert message.nested_field.int32_value == 4
    assert message.nested_different_pkg.sec == 0
    assert filled(msg.Defaults, bool_value=False).int8_value == msg.Defaults().int8_value


def test_nested_messages_in_arrays() -> None:
    message = filled(
        msg.UnboundedSequences, basic_types_values=[{'int8_value': 1}, {'int8_value': 2}]
    )
    assert [member.int8_value for member in message.basic_types_values] == [1, 2]


@pytest.mark.parametrize(
    'values', [[1, 2, 3], (1, 2, 3), np.array([1, 2, 3]), array.array('i', [1, 2, 3])], ids=type
)
def test_any_sequence_is_an_array(values: Any) -> None:
    for kind in (msg.Arrays, msg.BoundedSequences, msg.UnboundedSequences):
        message = filled(kind, int32_values=values, float32_values=values, byte_values=values)
        assert to_plain(message)['int32_values'] == [1, 2, 3]
        assert to_plain(message)['float32_values'] == [1.0, 2.0, 3.0]
        assert to_plain(message)['byte_values'] == [1, 2, 3]


def test_bytes_are_numbers() -> None:
    assert filled(msg.BasicTypes, byte_value=b'\x07').byte_value == b'\x07'
    assert to_plain(filled(msg.UnboundedSequences, byte_values=b'\x01\xff'))['byte_values'] == [
        1,
        255,
    ]


def test_numbers_of_numpy() -> None:
    message = filled(msg.BasicTypes, int32_value=np.int32(4), float64_value=np.float32(0.5))
    assert (message.int32_value, message.float64_value) == (4, 0.5)


def test_floats_that_are_no_numbers_pass() -> None:
    message = filled(msg.BasicTypes, float64_value=math.nan, float32_value=math.inf)
    assert math.isnan(to_plain(message)['float64_value'])
    assert to_plain(message)['float32_value'] == math.inf


@pytest.mark.parametrize(
    ('kind', 'fields', 'what'),
    [
        (msg.BasicTypes, {'int8_valu': 1}, 'there is no field int8_valu; it has bool_value'),
        (msg.Empty, {'x': 1}, 'there is no field x; it has none'),
        (msg.BasicTypes, {'int8_value': 128}, 'int8_value must be a whole number'),
        (msg.BasicTypes, {'int8_value': 'x'}, "int8_value must be .*not 'x'"),
        (msg.BasicTypes, {'int8_value': 1.0}, 'int8_value must be a whole number.*not 1.0'),
        (msg.BasicTypes, {'int8_value': True}, 'int8_value must be a whole number'),
        (msg.BasicTypes, {'bool_value': 1}, 'bool_value must be true or false'),
        (msg.BasicTypes, {'byte_value': 256}, 'byte_value must be'),
        (msg.BasicTypes, {'float32_value': 1e39}, 'float32_value must be'),
        (msg.BasicTypes, {'float64_value': None}, 'float64_value must be a number.*not None'),
        (msg.Strings, {'string_value': 5}, 'string_value must be text'),
        (msg.Strings, {'bounded_string_value': 'x' * 23}, 'at most 22 characters'),
        (msg.Strings, {'string_value': '\ud800'}, 'string_value is not a valid text'),
        (msg.Arrays, {'int32_values': [1, 2]}, 'int32_values must be a list of 3 values'),
        (msg.Arrays, {'int32_values': [1, 2, 'x']}, r'int32_values\[2\] must be'),
        (msg.BoundedSequences, {'int32_values': [1, 2, 3, 4]}, 'at most 3 values'),
        (msg.UnboundedSequences, {'string_values': 'abc'}, 'must be a list'),
        (msg.Builtins, {'time_value': 3}, 'time_value must be a mapping with fields of builtin'),
        (msg.Builtins, {'time_value': {'sec': 'x'}}, 'time_value.sec must be'),
        (
            msg.UnboundedSequences,
            {'basic_types_values': [{'int8_value': 999}]},
            r'basic_types_values\[0\].int8_value must be',
        ),
    ],
)
def test_what_does_not_fit_says_where_and_why(kind: Any, fields: Any, what: str) -> None:
    with pytest.raises(ValueError, match=what):
        fill(kind(), fields)


def test_field_value_follows_a_path() -> None:
    message = filled(msg.Builtins, time_value={'sec': 7})
    assert field_value(message, ['time_value', 'sec']) == 7
    assert field_value(message, ['time_value']) == {'sec': 7, 'nanosec': 0}


def test_interfaces_find_classes_and_fill_them() -> None:
    interfaces = InstalledInterfaces()
    goal = interfaces.action_class('test_msgs/action/Fibonacci').Goal()
    interfaces.fill(goal, {'order': 9})
    assert goal.order == 9
    assert interfaces.message_class('test_msgs/msg/Empty') is msg.Empty
