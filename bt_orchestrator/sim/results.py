"""The results of simulated controllers without `results` in the cell file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from bt_orchestrator.model.action_type import TASK_RESULT, ActionType, FieldType, Kind, MessageType
from bt_orchestrator.model.cell import Component, StateTopic
from bt_orchestrator.model.goal import words_field

_DEFAULTS: Mapping[Kind, Any] = {'bool': True, 'int': 0, 'float': 0.0, 'str': '', 'bytes': 0}

NUMBER = '{n}'

NOT_READY = 'NOT_READY'
"""The text of a simulated state topic when the component is not ready."""


def simulated_result(component: Component, action_type: ActionType, task: str) -> dict[str, Any]:
    """Return the result fields of a task that was done.

    Booleans are true, numbers 0, strings empty, sequences without members, unless the component's
    `results` say otherwise; they may name a part of a nested message only. `{n}` in a text stands
    for the number of the goal.
    """
    return _merged(_message(action_type.result), component.results.get(task, {}))


def as_failed(result: Mapping[str, Any]) -> dict[str, Any]:
    """Return the same result, of a task that was not done.

    A type without `task_result` cannot say so: its result is returned unchanged.
    """
    failed = {TASK_RESULT: False} if TASK_RESULT in result else {}
    return {**result, **failed}


def saying(action_type: ActionType, words: str) -> dict[str, Any]:
    """Return the fields of a result in which a controller says something of its own."""
    field = words_field(action_type.result)
    return {field: words} if field and words else {}


def numbered(result: Mapping[str, Any], number: int) -> dict[str, Any]:
    """Return the same result with a number for every `{n}` in its texts, nested ones too."""
    return {name: _numbered(value, number) for name, value in result.items()}


def _numbered(value: Any, number: int) -> Any:
    if isinstance(value, Mapping):
        return numbered(value, number)
    if isinstance(value, list):
        return [_numbered(member, number) for member in value]
    return value.replace(NUMBER, str(number)) if isinstance(value, str) else value


def as_read(result: Mapping[str, Any], number: float) -> dict[str, Any]:
    """Return the same result with another number in every float, nested ones too."""
    return {name: _read(value, number) for name, value in result.items()}


def _read(value: Any, number: float) -> Any:
    if isinstance(value, Mapping):
        return as_read(value, number)
    if isinstance(value, list):
        return [_read(member, number) for member in value]
    return number if isinstance(value, float) else value


def ready_value(state: StateTopic) -> Any:
    """Return what a simulated state topic says from the start."""
    return state.ready[0]


def not_ready_value(state: StateTopic) -> Any:
    """Return a value of the same type as the ready ones that differs from all of them."""
    ready = state.ready[0]
    if isinstance(ready, bool):
        return not ready
    if isinstance(ready, (int, float)):
        # Small and not negative, so that it fits the smallest unsigned type.
        return next(n for n in range(len(state.ready) + 1) if n not in state.ready)
    return NOT_READY if NOT_READY not in state.ready else f'{NOT_READY}_'


def _message(message: MessageType) -> dict[str, Any]:
    return {name: _value(field) for name, field in message.fields.items()}


def _value(field: FieldType) -> Any:
    if field.is_array:
        return [_single(field) for _ in range(field.array_length or 0)]
    return _single(field)


def _single(field: FieldType) -> Any:
    return _DEFAULTS[field.kind] if field.message is None else _message(field.message)


def _merged(default: Mapping[str, Any], given: Mapping[str, Any]) -> dict[str, Any]:
    merged = dict(default)
    for name, value in given.items():
        inner = default.get(name)
        if isinstance(value, Mapping) and isinstance(inner, Mapping):
            merged[name] = _merged(inner, value)
        else:
            merged[name] = value
    return merged
