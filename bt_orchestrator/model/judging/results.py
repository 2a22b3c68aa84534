"""Judgement of the results of a task: its verdict, and the identity and contents of its item."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from bt_orchestrator.base.errors import MissingResult
from bt_orchestrator.model.condition import Condition, holds
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.limits import SERIAL, cut
from bt_orchestrator.model.reference import Scope, as_text, look_up, references, resolve
from bt_orchestrator.model.script import Task
from bt_orchestrator.model.state import CellState
from bt_orchestrator.model.words import sentence


def why_refused(task: Task, results: Mapping[str, Any], scope: Scope) -> str | None:
    """Say why the verdict of a task refuses its results; None: it does not.

    :param scope: what references named when the task began
    """
    if task.fails_unless is None:
        return None
    judged = replace(scope, results={**scope.results, task.id: results})
    try:
        if holds(task.fails_unless, judged):
            return None
    except MissingResult as missing:
        return str(missing)
    wanted = with_bounds(task.fails_unless, judged)
    values = found_words(wanted, judged)
    return sentence('refused_result', wanted=wanted.words, found=values)


def with_bounds(condition: Condition, scope: Scope) -> Condition:
    """Return a condition with numbers in place of parameters.

    :raises MissingResult: the scope lacks a parameter
    """
    return replace(
        condition,
        at_least=resolve(condition.at_least, scope),
        at_most=resolve(condition.at_most, scope),
        all=tuple(with_bounds(part, scope) for part in condition.all),
        any=tuple(with_bounds(part, scope) for part in condition.any),
    )


def found_words(condition: Condition, scope: Scope) -> str:
    """Return the values that a condition compares; one value stands alone, others have names.

    :raises MissingResult: the scope lacks a value
    """
    named = dict.fromkeys(
        reference
        for comparison in condition.comparisons
        for reference in references(comparison.value)
    )
    values = {f'${{{name}}}': as_text(look_up(name, scope)) for name in named}
    if len(values) == 1:
        return next(iter(values.values()))
    return ', '.join(f'{name} = {value}' for name, value in values.items())


# The identity and the contents of an item: serial and lots (semantics 6.8, 6.9).


def serial_in(task: Task, results: Mapping[str, Any]) -> str:
    """Return the serial in the results of a task; empty: they have none.

    ROS fields are never absent: an empty text, or the number 0, was not set. Many readers end
    their texts with a line feed, so white space around it is not part of it.
    """
    if not task.own_serial:
        return ''
    scope = Scope({}, {}, {}, {task.id: results})
    try:
        value = look_up(task.own_serial, scope)
    except MissingResult:
        return ''
    return str(value).strip() if value else ''


def too_long(serial: str) -> str:
    """Say that a serial is too long; empty: it is not."""
    if len(serial) <= SERIAL:
        return ''
    return sentence('long_serial', most=SERIAL, found=len(serial))


def why_duplicate(state: CellState, item: str, task: Task, serial: str) -> str:
    """Say that a serial is known, of another item; empty: it is not.

    The serial that an item has already is no duplicate of itself.
    """
    if not serial or serial == state.items[item].serial or serial not in state.serials:
        return ''
    here = [other.id for other in state.items.values() if other.serial == serial]
    known, result = repr(serial), f'{".".join(task.identifies)}={serial}'
    if here:
        return sentence('serial_here', serial=known, item=here[0], result=result)
    return sentence('serial_before', serial=known, result=result)


def lots_of(job: Job) -> dict[str, str]:
    """Return what goes into each item of a job; a lot without a value is left out."""
    scope = Scope(job.params, {'id': job.id, 'quantity': job.quantity}, {}, {})
    lots = ((name, as_text(resolve(lot, scope)).strip()) for name, lot in job.script.lots.items())
    return {name: cut(lot, SERIAL) for name, lot in lots if lot}
