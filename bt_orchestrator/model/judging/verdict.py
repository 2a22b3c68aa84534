"""The verdict on the results of a task: `fails_unless` (semantics 2.8)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from bt_orchestrator.base.errors import MissingResult
from bt_orchestrator.model.condition import Condition, holds
from bt_orchestrator.model.reference import Scope, as_text, look_up, references, resolve
from bt_orchestrator.model.script import Task
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
    found = found_words(wanted, judged)
    return sentence('refused_result', wanted=wanted.words, found=found)


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
        reference for one in condition.comparisons for reference in references(one.value)
    )
    values = {f'${{{one}}}': as_text(look_up(one, scope)) for one in named}
    if len(values) == 1:
        return next(iter(values.values()))
    return ', '.join(f'{name} = {value}' for name, value in values.items())
