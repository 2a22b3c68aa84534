"""Task constants and labels (semantics 2.1)."""

from __future__ import annotations

from bt_orchestrator.model.action_type import ActionType
from bt_orchestrator.model.words import sentence
from bt_orchestrator.script.fields import Fields
from bt_orchestrator.script.report import Place, Report, did_you_mean, listing
from bt_orchestrator.script.yaml_nodes import quoted


def check_task_name(name: str, type_: ActionType, place: Place, report: Report) -> None:
    """Report a task that an action type does not have; without a task field any label will do."""
    hint = _why_not(name, type_)
    if hint:
        report.add(place, f'{type_.name} has no task {quoted(name)}', hint)


def wrong_task(name: str, type_: ActionType) -> str:
    """Say why an action type does not have a task; empty: it has."""
    hint = _why_not(name, type_)
    if not hint:
        return ''
    return sentence('no_such_task', type=type_.name, task=quoted(name), words=hint)


def _why_not(name: str, type_: ActionType) -> str:
    if not type_.has_task_field or name in type_.constants:
        return ''
    known = listing(type_.constants)
    otherwise = sentence('its_tasks', tasks=known) if known else sentence('add_constant')
    return did_you_mean(name, type_.constants, otherwise)


def default_task_name(type_: ActionType) -> str:
    """Return the label of a task that names none: the last part of the type's name."""
    return type_.name.rpartition('/')[2]


def read_task_name(fields: Fields, type_: ActionType, missing: str, hint: str = '') -> str:
    """Return the task that the key `task` names.

    A type without a task field needs none; the label is then the type's own name.

    :param missing: what is wrong if there must be one, and is not
    :param hint: what to do then; else its tasks are told
    """
    name = fields.text('task')
    if name is not None:
        check_task_name(name, type_, fields.place('task'), fields.report)
    elif type_.has_task_field and fields.is_sure('task'):
        hint = hint or f'name one of {listing(type_.constants)}'
        fields.report.add(fields.node.place, missing, hint)
    return name or default_task_name(type_)
