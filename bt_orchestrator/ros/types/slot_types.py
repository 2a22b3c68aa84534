"""From the types that rosidl generates for a message's fields to the model's."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

from rosidl_parser.definition import (
    AbstractNestedType,
    AbstractString,
    AbstractWString,
    Array,
    BasicType,
    BoundedSequence,
    NamespacedType,
)

from bt_orchestrator.model.action_type import FieldType, MessageType
from bt_orchestrator.ros.types.interface_classes import message_class
from bt_orchestrator.script.field_types import SIMPLE_TYPES


@cache
def message_type(message: Any, name: str = '') -> MessageType:
    """Describe a generated message class."""
    names = message.get_fields_and_field_types()
    fields = {field: _field(slot) for field, slot in zip(names, message.SLOT_TYPES, strict=True)}
    return MessageType(name or message.__name__, fields)


def _field(slot: Any) -> FieldType:
    if not isinstance(slot, AbstractNestedType):
        return _single(slot)
    single = _single(slot.value_type)
    if isinstance(slot, Array):
        return replace(
            single,
            ros_name=f'{single.ros_name}[{slot.size}]',
            is_array=True,
            array_length=slot.size,
        )
    longest = slot.maximum_size if isinstance(slot, BoundedSequence) else None
    size = '' if longest is None else f'<={longest}'
    return replace(
        single, ros_name=f'{single.ros_name}[{size}]', is_array=True, array_maximum=longest
    )


def _single(slot: Any) -> FieldType:
    if isinstance(slot, BasicType):
        return SIMPLE_TYPES[slot.typename]
    if isinstance(slot, (AbstractString, AbstractWString)):
        return _text(slot)
    if isinstance(slot, NamespacedType):
        name = '/'.join(slot.namespaced_name())
        return FieldType('message', name, message=message_type(message_class(name), name))
    raise TypeError(f'unknown field type {slot!r}')


def _text(slot: Any) -> FieldType:
    name = 'wstring' if isinstance(slot, AbstractWString) else 'string'
    if not slot.has_maximum_size():
        return SIMPLE_TYPES[name]
    longest = int(slot.maximum_size)
    return FieldType('str', f'{name}<={longest}', string_maximum=longest)
