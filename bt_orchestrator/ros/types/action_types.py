"""The facts of the installed interface packages about action and message types."""

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

from bt_orchestrator.base.errors import UnknownActionType
from bt_orchestrator.model.action_type import ActionType, FieldType, MessageType
from bt_orchestrator.ros.types.interface_classes import action_class, message_class
from bt_orchestrator.script.field_types import SIMPLE_TYPES
from bt_orchestrator.script.report import did_you_mean, listing


class InstalledActionTypes:
    """Reads the generated Python classes. Implements `ports.ActionTypes`.

    Needs the packages, but neither rclpy nor a ROS context: it also serves `check`.
    """

    def __init__(self) -> None:
        self._actions: dict[str, ActionType] = {}

    def action(self, name: str) -> ActionType:
        """Return the description of an action type such as pkg/action/Name.

        :raises UnknownActionType: it is not installed, or is no action type
        """
        if name not in self._actions:
            interface = action_class(name)
            self._actions[name] = ActionType(
                name,
                message_type(interface.Goal, f'{name}_Goal'),
                message_type(interface.Result, f'{name}_Result'),
                _constants(interface.Goal),
            )
        return self._actions[name]

    def message_field(self, type_name: str, field: str) -> str:
        """Return the ROS name of the type of a message's field.

        :param field: its name, or a path into nested messages such as status.mode
        :raises UnknownActionType: the message type is not installed or has no such field
        """
        message: MessageType | None = message_type(message_class(type_name), type_name)
        field_type: FieldType | None = None
        for part in field.split('.'):
            if message is None or part not in message.fields:
                raise _no_such_field(type_name, field, part, message)
            field_type = message.fields[part]
            message = None if field_type.is_array else field_type.message
        return field_type.ros_name if field_type else ''


def _constants(goal_class: Any) -> dict[str, Any]:
    """Return the constants of a message class.

    The class itself mixes them with defaults of fields; its metaclass keeps them apart.
    """
    metaclass = type(goal_class)
    return dict(getattr(metaclass, f'_{metaclass.__name__}__constants', {}))


def _no_such_field(
    type_name: str, field: str, part: str, message: MessageType | None
) -> UnknownActionType:
    if message is None:
        what = f'{type_name} has no field `{field}`: nothing is inside `{field[: -len(part) - 1]}`'
        return UnknownActionType(type_name, what, 'name a field that holds one value')
    known = list(message.fields)
    hint = did_you_mean(part, known, f'{message.name} has {listing(known)}')
    return UnknownActionType(type_name, f'{type_name} has no field `{field}`', hint)


# From the types that rosidl generates for a message's fields to the model's.


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
