"""Tasks and conditions as the mappings that a script has for them; defaults are left out."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from bt_orchestrator.model.cell import Cell, OnFailure
from bt_orchestrator.model.condition import Condition
from bt_orchestrator.model.script import RunsFor, Task

Row = dict[str, Any]


def task_row(task: Task, cell: Cell | None, default_id: str) -> Row:
    """Return a task as a script says it, its keys in the order of the reference.

    :param default_id: the id that it has where it stands, if none is written
    """
    return dict(_task_keys(task, cell, default_id))


def _task_keys(task: Task, cell: Cell | None, default_id: str) -> Iterator[tuple[str, Any]]:
    if task.id != default_id:
        yield 'id', task.id
    yield 'task', task.name
    yield 'action', task.action
    if task.args:
        yield 'args', task.args
    if not task.requires_conveyor:
        yield 'requires_conveyor', False
    if task.qty_change:
        yield 'qty_change', task.qty_change
    if task.on_failure is not OnFailure.HOLD:
        yield 'on_failure', task.on_failure.value
    if task.retries:
        yield 'retries', task.retries
    if task.retry_delay_s:
        yield 'retry_delay', task.retry_delay_s
    if cell is None or task.timeout_s != cell.components[task.component].timeout_s:
        yield 'timeout', 'none' if task.timeout_s is None else task.timeout_s
    if task.repeatable:
        yield 'repeatable', True
    yield from _conditions(task)
    if task.identifies:
        yield 'identifies', '.'.join(task.identifies)
    if task.runs_for is not RunsFor.GOOD:
        yield 'runs_for', task.runs_for.value
    if task.once:
        yield 'once', True


def _conditions(task: Task) -> Iterator[tuple[str, Any]]:
    if task.condition is not None:
        yield 'unless' if task.condition.negated else 'when', condition_row(task.condition)
    if task.fails_unless is not None:
        yield 'fails_unless', condition_row(task.fails_unless)


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
