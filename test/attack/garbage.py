"""Values that hurt, for every field that ROS 2 knows."""

from __future__ import annotations

import math
import random
import sys
from typing import Any

from bt_orchestrator.model.action_type import FieldType, MessageType
from bt_orchestrator.ros.types.action_types import message_type
from bt_orchestrator.ros.types.messages import fill

LONG = 1_000_000

_FLOATS = (
    math.nan,
    math.inf,
    -math.inf,
    sys.float_info.max,
    -sys.float_info.max,
    sys.float_info.min,
    5e-324,
    -0.0,
    2.0**63,
)

_TEXTS = (
    '',
    ' ',
    '/',
    '..',
    '../../../etc/passwd',
    '/proc/kmsg',
    '/dev/zero',
    '.yaml',
    'é\n\t☃',
    '\x1b]0;owned\x07\x1b[2J',
    '\u202eltr\u2066',
    '${x}',
    '%s%n%d',
    '"; DROP TABLE events; --',
    '{"a": [',
    '{"$float": "nan"}',
    '\x7f\x01',
    '-1',
    'None',
    'nan',
    '*&!|>%@`',
    '\U0010ffff',
    'a' * 5000,
)

MOST_IN_SEQUENCE = 5
MOST_DEPTH = 4


def message(drawn: random.Random, kind: Any) -> Any:
    """Return a message of a generated class, with something that hurts in every field."""
    made = kind()
    fill(made, fields(drawn, message_type(kind)))
    return made


def fields(drawn: random.Random, type_: MessageType, depth: int = 0) -> dict[str, Any]:
    """Return values for the fields of a type."""
    return {name: _value(drawn, field, depth) for name, field in type_.fields.items()}


def text(drawn: random.Random) -> str:
    """Return a text that hurts, or a random one."""
    if drawn.random() < 0.7:
        return drawn.choice(_TEXTS)
    return ''.join(chr(_code(drawn)) for _ in range(drawn.randint(1, 40)))


def _code(drawn: random.Random) -> int:
    """Return a character, which is neither half of a pair nor the end of a text in C."""
    return drawn.choice((drawn.randint(1, 0x7F), drawn.randint(0xA0, 0xD7FF)))


def _value(drawn: random.Random, field: FieldType, depth: int) -> Any:
    if not field.is_array:
        return _single(drawn, field, depth)
    most = MOST_IN_SEQUENCE if field.array_maximum is None else field.array_maximum
    length = drawn.randint(0, most) if field.array_length is None else field.array_length
    if depth >= MOST_DEPTH and field.array_length is None:
        length = 0
    return [_single(drawn, field, depth + 1) for _ in range(length)]


def _single(drawn: random.Random, field: FieldType, depth: int) -> Any:
    if field.message is not None:
        return fields(drawn, field.message, depth + 1)
    if field.kind == 'float':
        small = field.ros_name == 'float32'
        values = [x for x in _FLOATS if not small or not math.isfinite(x) or abs(x) < 1e38]
        return drawn.choice(values)
    if field.kind == 'int':
        assert field.minimum is not None
        assert field.maximum is not None
        return drawn.choice((field.minimum, field.maximum, 0 if field.minimum < 0 else 1))
    if field.kind == 'bool':
        return drawn.random() < 0.5
    if field.kind == 'bytes':
        return drawn.randrange(256)
    return text(drawn)[: field.string_maximum]
