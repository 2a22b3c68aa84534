"""The field types that a referenced value may be given to."""

from __future__ import annotations

from bt_orchestrator.model.action_type import FieldType
from bt_orchestrator.script.field_types import PARAMETER_TYPES

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
