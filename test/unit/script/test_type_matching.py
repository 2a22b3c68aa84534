"""Which types a referenced value may be given to."""

from __future__ import annotations

import pytest
from fakes.action_types import (
    BOOL,
    FLOAT32,
    FLOAT64,
    INT32,
    POINT,
    POSE_FIELD,
    STRING,
    UINT8,
    array,
)

from bt_orchestrator.model.action_type import FieldType
from bt_orchestrator.script.field_types import (
    PARAMETER_TYPES,
    in_words,
    is_assignable,
    is_printable,
)

POINT_FIELD = FieldType('message', POINT.name, message=POINT)


@pytest.mark.parametrize(
    ('given', 'needed', 'expected'),
    [
        (BOOL, BOOL, True),
        (INT32, UINT8, True),
        (INT32, FLOAT32, True),
        (FLOAT64, INT32, False),
        (BOOL, INT32, False),
        (INT32, BOOL, False),
        (STRING, FLOAT64, False),
        (FLOAT64, STRING, False),
        (POSE_FIELD, POSE_FIELD, True),
        (POSE_FIELD, POINT_FIELD, False),
        (POSE_FIELD, STRING, False),
        (STRING, POSE_FIELD, False),
        (array(UINT8), UINT8, False),
        (UINT8, array(UINT8), False),
        (array(UINT8), array(UINT8, length=3), True),
        (array(UINT8, length=2), array(UINT8, length=3), False),
        (array(UINT8), array(FLOAT64), True),
        (array(STRING), array(FLOAT64), False),
        (array(POSE_FIELD), array(POSE_FIELD), True),
        (array(POSE_FIELD), array(POINT_FIELD), False),
        (PARAMETER_TYPES['int'], FLOAT64, True),
        (PARAMETER_TYPES['str'], FLOAT64, False),
    ],
)
def test_assignment(given: FieldType, needed: FieldType, expected: bool) -> None:
    assert is_assignable(given, needed) is expected


@pytest.mark.parametrize(
    ('type_', 'words'),
    [
        (STRING, 'text (string)'),
        (PARAMETER_TYPES['str'], 'text'),
        (UINT8, 'a whole number (uint8)'),
        (array(FLOAT64, length=3), 'float64[3]'),
        (POSE_FIELD, 'test_interfaces/msg/Pose'),
    ],
)
def test_types_in_words(type_: FieldType, words: str) -> None:
    assert in_words(type_) == words


def test_only_single_plain_values_are_printable_in_text() -> None:
    assert is_printable(FLOAT64)
    assert not is_printable(array(FLOAT64))
    assert not is_printable(POSE_FIELD)
    assert not is_printable(FieldType('bytes', 'byte'))
