"""Tasks and conditions as the mappings that a script has for them; defaults are left out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from enum import Enum
from typing import Any

from bt_orchestrator.model.cell import Cell, OnFailure
from bt_orchestrator.model.condition import Condition
from bt_orchestrator.model.script import Task
from bt_orchestrator.script.keys import Key
from bt_orchestrator.script.task_keys import INITIALIZATION_TASK, TASK

Row = dict[str, Any]


def task_row(task: Task, cell: Cell | None, default_id: str) -> Row:
    """Return a task as a script says it, its keys in the order of the reference.

    :param default_id: the id that it has where it stands, if none is written
    """
    own = _own_keys(task, cell, default_id)
    values = ((key.name, own[key.name] if key.name in own else _set(key, task)) for key in _KEYS)
    return {name: value for name, value in values if value is not None}


_KEYS = (*TASK.keys, INITIALIZATION_TASK.by_name['once'])


def _set(key: Key, task: Task) -> Any:
    """Return what a key sets; None: what holds when it is absent."""
    value = getattr(task, key.sets) if key.sets else key.default
    plain = value.value if isinstance(value, Enum) else value
    return None if plain == key.default else plain


def _own_keys(task: Task, cell: Cell | None, default_id: str) -> Mapping[str, Any]:
    """Return the keys that say more than one field; None: not written."""
    condition, limit = task.condition, task.timeout_s
    is_usual = cell is not None and limit == cell.components[task.component].timeout_s
    when = (
        {}
        if condition is None
        else {'unless' if condition.negated else 'when': condition_row(condition)}
    )
    return {
        'id': task.id if task.id != default_id else None,
        'task': task.name,
        'action': task.action,
        'args': task.args or None,
        'on_failure': task.on_failure.value if task.on_failure is not OnFailure.HOLD else None,
        'timeout': None if is_usual else 'none' if limit is None else limit,
        **when,
        'fails_unless': task.fails_unless and condition_row(task.fails_unless),
        'identifies': '.'.join(task.identifies) or None,
        'setup': task.setup or None,
    }


def condition_row(condition: Condition) -> Any:
    """Return a condition as a script says it; a boolean needs no comparison."""
    if condition.parts:
        key = 'all' if condition.all else 'any'
        return {key: [condition_row(part) for part in condition.parts]}
    compared = dict(_comparison(condition))
    return {'value': condition.value, **compared} if compared else condition.value


def _comparison(condition: Condition) -> Iterator[tuple[str, Any]]:
    low, high = condition.at_least, condition.at_most
    if condition.one_of:
        yield 'one_of', condition.one_of
    elif condition.not_equals is not None:
        yield 'not_equals', condition.not_equals
    elif low is not None and high is not None:
        yield 'between', [low, high]
    elif low is not None:
        yield 'at_least', low
    elif high is not None:
        yield 'at_most', high
    elif condition.equals is not True:
        yield 'equals', condition.equals
