"""Plain values against types of fields."""

from __future__ import annotations

import math

import pytest
from fakes.action_types import POSE_FIELD, UINT8, array

from bt_orchestrator.model.action_type import FieldType
from bt_orchestrator.script.field_types import (
    list_fits,
    misfit,
    needed_list,
    simple_type,
)


def simple(ros_name: str) -> FieldType:
    type_ = simple_type(ros_name)
    assert type_ is not None
    return type_


@pytest.mark.parametrize(
    ('ros_name', 'fits', 'does_not'),
    [
        ('bool', [True, False], [0, 1, 'true', None]),
        ('boolean', [True], [1]),
        ('uint8', [0, 255], [-1, 256, True, 1.0, '1', None]),
        ('int8', [-128, 127], [-129, 128]),
        ('int64', [-(2**63), 2**63 - 1], [2**63]),
        ('uint64', [2**64 - 1], [2**64, -1]),
        ('byte', [0, 255], [256, 'a']),
        ('char', [0, 255], [256]),
        ('float64', [0, 1.5, -1e300], [math.inf, math.nan, 10**400, True, '1', None]),
        ('float32', [3.4e38], [3.5e38]),
        ('double', [1e300], ['1']),
        ('string', ['', 'a'], [1, True, None, 1.5]),
        ('wstring', ['a'], [1]),
        ('string<=3', ['abc'], ['abcd']),
    ],
)
def test_what_fits(ros_name: str, fits: list[object], does_not: list[object]) -> None:
    type_ = simple(ros_name)
    assert [value for value in fits if misfit(value, type_)] == []
    assert [value for value in does_not if misfit(value, type_) is None] == []


@pytest.mark.parametrize('name', ['string[]', 'float64[3]', 'sequence<string>', 'a/b', ''])
def test_arrays_and_messages_are_not_simple(name: str) -> None:
    assert simple_type(name) is None


@pytest.mark.parametrize(
    ('value', 'ros_name', 'needed', 'hint'),
    [
        (300, 'uint8', 'a whole number from 0 to 255 (uint8)', 'choose a number in that range'),
        ('3', 'uint8', 'a whole number from 0 to 255 (uint8)', 'write 3 without quotes'),
        ('x', 'int64', 'a whole number (int64)', 'write a whole number, without quotes'),
        ('1.5', 'double', 'a number (float64)', 'write 1.5 without quotes'),
        ('true', 'double', 'a number (float64)', 'write a number, without quotes'),
        (5, 'string', 'text (string)', 'put it in quotes'),
        ([], 'string', 'text (string)', 'write a text'),
        (1, 'bool', 'true or false (bool)', 'write true or false, without quotes'),
    ],
)
def test_why_it_does_not_fit(value: object, ros_name: str, needed: str, hint: str) -> None:
    assert misfit(value, simple(ros_name)) == (needed, hint)


def test_a_message_is_no_plain_value() -> None:
    problem = misfit(1, POSE_FIELD)
    assert problem is not None
    assert problem.needed == 'a mapping (test_interfaces/msg/Pose)'


@pytest.mark.parametrize(
    ('type_', 'fits', 'does_not', 'words'),
    [
        (array(UINT8), [0, 9], [], 'a list (uint8[])'),
        (array(UINT8, length=3), [3], [2, 4], 'a list of 3 values (uint8[3])'),
        (array(UINT8, longest=2), [0, 2], [3], 'a list of at most 2 values (uint8[<=2])'),
    ],
)
def test_lists(type_: FieldType, fits: list[int], does_not: list[int], words: str) -> None:
    assert all(list_fits(length, type_) for length in fits)
    assert not any(list_fits(length, type_) for length in does_not)
    assert needed_list(type_) == words
