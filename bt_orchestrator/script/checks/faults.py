"""Faults of simulated controllers against the component and the action type they strike at."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from bt_orchestrator.model.action_type import TASK_RESULT, ActionType
from bt_orchestrator.model.fault import Fault, FaultKind
from bt_orchestrator.model.goal import words_field
from bt_orchestrator.script.report import did_you_mean, listing

_OF_STATE = (FaultKind.NOT_READY, FaultKind.SILENT)


class Unseen(NamedTuple):
    """Why a fault could never be seen."""

    what: str
    hint: str


def unseen(
    fault: Fault, component: str, action_type: ActionType, *, has_state: bool
) -> Iterator[Unseen]:
    """Yield why a fault of a component could never be seen; nothing: it can."""
    wrong_task = _wrong_task(fault.task, component, action_type) if fault.task else None
    if wrong_task is not None:
        yield wrong_task
    if fault.kind in _OF_STATE and not has_state:
        what = f'component `{component}` has no state topic in the cell file'
        yield Unseen(what, 'remove the fault, or give the component a `state`')
    if fault.kind is FaultKind.FALSE and TASK_RESULT not in action_type.result.fields:
        what = f'the Result of {action_type.name} has no field `{TASK_RESULT}`'
        yield Unseen(what, 'let it `abort` instead')
    if fault.words and not words_field(action_type.result):
        what = f'the Result of {action_type.name} has no text field for {fault.words!r}'
        yield Unseen(what, 'leave the words out')


def _wrong_task(task: str, component: str, action_type: ActionType) -> Unseen | None:
    if not action_type.has_task_field:
        what = f'{action_type.name} has no task field, its goals cannot be told apart'
        return Unseen(what, f'leave the task out: {component}.#1=...')
    constants = action_type.constants
    if task in constants or not constants:
        return None
    hint = did_you_mean(task, constants, f'its tasks are {listing(constants)}')
    return Unseen(f'{action_type.name} has no task `{task}`', hint)
