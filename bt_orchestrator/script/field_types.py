"""Plain values, and references to values, against the types of ROS 2 fields: what fits."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import NamedTuple

from bt_orchestrator.model.action_type import FieldType
from bt_orchestrator.model.words import sentence
from bt_orchestrator.script.yaml_nodes import plain_value

LARGEST_FLOAT32 = 3.4028235e38

LARGEST_FLOAT64 = 1.7976931348623157e308

ONE_BYTE = 255

MOST_IN_WORDS = 2**31
"""Ranges beyond this are shown only if they are exceeded."""


class Misfit(NamedTuple):
    """Why a value does not fit a type."""

    needed: str
    """The values that would fit: a whole number from 0 to 255 (uint8)."""
    hint: str


def _integers() -> dict[str, FieldType]:
    types = {}
    for bits in (8, 16, 32, 64):
        half = 2 ** (bits - 1)
        types[f'int{bits}'] = FieldType('int', f'int{bits}', -half, half - 1)
        types[f'uint{bits}'] = FieldType('int', f'uint{bits}', 0, 2 * half - 1)
    return types


SIMPLE_TYPES: Mapping[str, FieldType] = {
    'bool': FieldType('bool', 'bool'),
    'boolean': FieldType('bool', 'bool'),
    'byte': FieldType('bytes', 'byte'),
    'octet': FieldType('bytes', 'byte'),
    'char': FieldType('int', 'char', 0, ONE_BYTE),
    'float': FieldType('float', 'float32'),
    'float32': FieldType('float', 'float32'),
    'double': FieldType('float', 'float64'),
    'float64': FieldType('float', 'float64'),
    'string': FieldType('str', 'string'),
    'wstring': FieldType('str', 'wstring'),
    **_integers(),
}
"""Types of one value, by the names that ROS 2 and IDL give them."""

PARAMETER_TYPES: Mapping[str, FieldType] = {
    'str': FieldType('str', 'str'),
    'int': FieldType('int', 'int', -(2**63), 2**63 - 1),
    'float': FieldType('float', 'float'),
    'bool': FieldType('bool', 'bool'),
}
"""The types of a script's parameters."""


_NOT_FINITE = ('nan', 'inf', 'infinity')
"""Texts in which other programs write no finite number; JSON and a shell carry them as texts."""


def simple_type(ros_name: str) -> FieldType | None:
    """Return the type of a field that holds one value; None for arrays and messages."""
    bounded = re.fullmatch(r'(w?string)<=(\d+)', ros_name)
    if bounded:
        return FieldType('str', ros_name, string_maximum=int(bounded.group(2)))
    return SIMPLE_TYPES.get(ros_name)


def misfit(value: object, type_: FieldType) -> Misfit | None:
    """Say why a plain value does not fit a field that holds one value; None if it fits.

    A boolean is no number; a whole number fits a float. A byte is a number from 0 to 255.
    """
    if type_.kind == 'bool':
        unfit = Misfit(_named('boolean', type_), sentence('bare_boolean'))
        return None if isinstance(value, bool) else unfit
    if type_.kind in ('int', 'bytes'):
        return _int_misfit(value, type_)
    if type_.kind == 'float':
        return _float_misfit(value, type_)
    if type_.kind == 'str':
        return _str_misfit(value, type_)
    return Misfit(f'a mapping ({type_.ros_name})', 'write {field: value, ...}')


def needed_list(type_: FieldType) -> str:
    """Say what a list must be, for a message."""
    if type_.array_length is not None:
        return f'a list of {type_.array_length} values ({type_.ros_name})'
    if type_.array_maximum is not None:
        return f'a list of at most {type_.array_maximum} values ({type_.ros_name})'
    return f'a list ({type_.ros_name})'


def list_fits(length: int, type_: FieldType) -> bool:
    """Tell whether a list may have this length."""
    if type_.array_length is not None:
        return length == type_.array_length
    return type_.array_maximum is None or length <= type_.array_maximum


def _int_misfit(value: object, type_: FieldType) -> Misfit | None:
    low = 0 if type_.kind == 'bytes' else type_.minimum
    high = ONE_BYTE if type_.kind == 'bytes' else type_.maximum
    is_bounded = low is not None and high is not None
    needed = _named('whole_from' if is_bounded else 'whole', type_, low=low, high=high)
    if isinstance(value, bool) or not isinstance(value, int):
        if high is not None and high > MOST_IN_WORDS:
            needed = _named('whole', type_)
        return Misfit(needed, _number_hint(value, sentence('bare_whole')))
    if (low is not None and value < low) or (high is not None and value > high):
        return Misfit(needed, sentence('in_range'))
    return None


def _float_misfit(value: object, type_: FieldType) -> Misfit | None:
    needed = _named('number', type_)
    if isinstance(value, str) and value.lower().lstrip('.+-') in _NOT_FINITE:
        return Misfit(_named('finite', type_), sentence('measured'))
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return Misfit(needed, _number_hint(value, sentence('bare_number')))
    largest = LARGEST_FLOAT32 if type_.ros_name.startswith('float32') else LARGEST_FLOAT64
    if not -largest <= value <= largest:
        return Misfit(_named('finite', type_), f'choose one up to {largest:g}')
    return None


def _str_misfit(value: object, type_: FieldType) -> Misfit | None:
    if not isinstance(value, str):
        hint = 'put it in quotes' if isinstance(value, (bool, int, float)) else 'write a text'
        return Misfit(_named('text', type_), hint)
    longest = type_.string_maximum
    if longest is not None and len(value) > longest:
        return Misfit(_named('text_most', type_, most=longest), sentence('shorten'))
    return None


def _number_hint(value: object, otherwise: str) -> str:
    """Offer the number inside a quoted text; other texts need a number first."""
    if isinstance(value, str):
        inner = plain_value(value)
        if isinstance(inner, (int, float)) and not isinstance(inner, bool):
            return sentence('bare', value=value)
    return otherwise


def _named(kind: str, type_: FieldType, **values: object) -> str:
    return sentence(kind, type=type_.ros_name, **values)


# The field types that a referenced value may be given to.

_WORDS = {'bool': 'a boolean', 'int': 'a whole number', 'float': 'a number', 'str': 'text'}


def is_assignable(given: FieldType, needed: FieldType) -> bool:
    """Tell whether every kind of value of one type may go into a field of the other.

    A whole number fits a float, nothing else changes its kind. Ranges and lengths are not
    compared: a 64 bit result that is always small may go into a small field. An array goes into
    an array of the same members, a message into a field of the same message.
    """
    if given.is_array != needed.is_array:
        return False
    if given.is_array and not _lengths_agree(given, needed):
        return False
    if given.kind == 'message' or needed.kind == 'message':
        return _message_name(given) is not None and _message_name(given) == _message_name(needed)
    return given.kind == needed.kind or (given.kind, needed.kind) == ('int', 'float')


def is_printable(type_: FieldType) -> bool:
    """Tell whether a value of this type can be put into a longer text."""
    return not type_.is_array and type_.kind in _WORDS


def in_words(type_: FieldType) -> str:
    """Name a type for a message: text (string), a whole number (uint8), float64[3]."""
    if type_.is_array or type_.kind not in _WORDS:
        return type_.ros_name
    if type_ in PARAMETER_TYPES.values():
        return _WORDS[type_.kind]
    return f'{_WORDS[type_.kind]} ({type_.ros_name})'


def _lengths_agree(given: FieldType, needed: FieldType) -> bool:
    lengths = (given.array_length, needed.array_length)
    return None in lengths or lengths[0] == lengths[1]


def _message_name(type_: FieldType) -> str | None:
    return type_.message.name if type_.message else None
