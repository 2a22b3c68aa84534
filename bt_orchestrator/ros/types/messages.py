"""ROS 2 messages from plain values and back."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache
from typing import Any

from bt_orchestrator.model.action_type import FieldType, MessageType
from bt_orchestrator.ros.types.action_types import message_type
from bt_orchestrator.ros.types.interface_classes import action_class, message_class
from bt_orchestrator.script.field_types import list_fits, misfit, needed_list


class InstalledInterfaces:
    """The classes of the installed interface packages, and how they are filled."""

    def action_class(self, name: str) -> Any:
        """Return the class of an action type such as pkg/action/Name.

        :raises UnknownActionType: it is not installed, or is no action type
        """
        return action_class(name)

    def message_class(self, name: str) -> Any:
        """Return the class of a message type such as pkg/msg/Name.

        :raises UnknownActionType: it is not installed, or is no message type
        """
        return message_class(name)

    def fill(self, message: Any, fields: Mapping[str, Any]) -> None:
        """Set fields from plain values; see `fill`."""
        fill(message, fields)


def fill(message: Any, fields: Mapping[str, Any]) -> None:
    """Set fields of a message from plain values; fields not named keep their value.

    Nested messages are mappings, arrays any sequence (numpy's too), a byte is a number. Every
    value is checked: rclpy does not, and a wrong one would end the process when it is sent.

    :raises ValueError: says which field, what was expected and what was found
    """
    _fill(message, fields, '')


def check(message: Any) -> None:
    """Check that every field of a message can be sent: a wrong one would end the process.

    :raises ValueError: says which field, what was expected and what was found
    """
    fill(type(message)(), to_plain(message))


def to_plain(message: Any) -> dict[str, Any]:
    """Return a message's fields as plain values, which JSON can carry.

    A byte becomes a number, an array a list. Floats that are no numbers stay so (nan, inf), and
    every nan becomes `math.nan`, so that equal messages have equal values.
    """
    kind: Any = type(message)
    return {name: convert(getattr(message, name)) for name, convert in _table(kind)}


def field_value(message: Any, path: Sequence[str]) -> Any:
    """Return the plain value of one field, named by a path into nested messages."""
    value = message
    for name in path:
        value = getattr(value, name)
    return _plain(value)


def _fill(message: Any, fields: Mapping[str, Any], where: str) -> None:
    generated: Any = type(message)
    type_ = message_type(generated)
    for name, value in fields.items():
        place = f'{where}{name}'
        field = type_.fields.get(name)
        if field is None:
            raise ValueError(f'there is no field {place}; {_known(type_)}')
        setattr(message, name, _value(value, field, getattr(message, name), place))


def _value(value: Any, field: FieldType, present: Any, place: str) -> Any:
    """Return what a field is set to.

    :param present: what it holds now; for a message, what unnamed fields keep
    """
    if not field.is_array:
        return _single(value, field, present, place)
    members = value.tolist() if hasattr(value, 'tolist') else value
    if isinstance(members, (bytes, bytearray)):
        members = list(members)
    if not isinstance(members, (list, tuple)) or not list_fits(len(members), field):
        raise ValueError(f'{place} must be {needed_list(field)}, not {_shown(value)}')
    return [
        _single(member, field, None, f'{place}[{number}]') for number, member in enumerate(members)
    ]


def _single(value: Any, field: FieldType, present: Any, place: str) -> Any:
    if field.message is not None:
        return _message(value, field.message, present, place)
    if hasattr(value, 'item'):
        value = value.item()  # a number of numpy's
    if field.kind == 'bytes' and isinstance(value, bytes) and len(value) == 1:
        return value
    # No goal has such a number (semantics 6.3), but an answer of a simulated controller may.
    not_finite = isinstance(value, float) and not math.isfinite(value)
    problem = None if not_finite and field.kind == 'float' else misfit(value, field)
    if problem is not None:
        raise ValueError(f'{place} must be {problem.needed}, not {_shown(value)}')
    if field.kind == 'str':
        _check_encodable(value, place)
    if field.kind == 'bytes':
        return bytes([value])
    return float(value) if field.kind == 'float' else value


def _message(value: Any, type_: MessageType, present: Any, place: str) -> Any:
    if not isinstance(value, Mapping):
        what = f'{place} must be a mapping with fields of {type_.name}'
        raise ValueError(f'{what}, not {_shown(value)}')
    message = message_class(type_.name)() if present is None else present
    _fill(message, value, f'{place}.')
    return message


def _check_encodable(text: str, place: str) -> None:
    try:
        text.encode()
    except UnicodeEncodeError as error:
        raise ValueError(f'{place} is not a valid text: {error.reason}') from error


@cache
def _table(kind: Any) -> Sequence[tuple[str, Callable[[Any], Any]]]:
    """Return how each field of a generated message class becomes plain, made once."""
    fields = message_type(kind).fields
    return [(name, _conversion(fields[name])) for name in kind.get_fields_and_field_types()]


def _conversion(field: FieldType) -> Callable[[Any], Any]:
    if field.is_array:
        return _plain
    return {'float': _number, 'bool': _same, 'int': _same, 'str': _same}.get(field.kind, _plain)


def _same(value: Any) -> Any:
    return value


def _number(value: Any) -> Any:
    return value if value == value else math.nan  # noqa: PLR0124 - nan is not equal to itself


def _plain(value: Any) -> Any:
    if isinstance(value, float):
        return _number(value)
    if isinstance(value, (bool, int, str)):
        return value
    if isinstance(value, bytes):
        return value[0]
    if hasattr(value, 'get_fields_and_field_types'):
        return to_plain(value)
    if hasattr(value, 'tolist'):
        numbers = value.tolist()
        has_nan = any(isinstance(number, float) and math.isnan(number) for number in numbers)
        return [_plain(number) for number in numbers] if has_nan else numbers
    if isinstance(value, Iterable):
        return [_plain(member) for member in value]
    return value  # nothing that a field can hold, which `check` tells


def _known(type_: MessageType) -> str:
    return f'it has {", ".join(type_.fields)}' if type_.fields else 'it has none'


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f'{text[:57]}...'
