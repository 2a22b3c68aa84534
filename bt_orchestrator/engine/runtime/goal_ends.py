"""The event of the end of a goal: what the end means, and what the controller said of it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from bt_orchestrator.model import events as e
from bt_orchestrator.model.action_type import TASK_RESULT
from bt_orchestrator.model.codec import json_of
from bt_orchestrator.model.failures import ABORT
from bt_orchestrator.model.goal import GoalEnd, GoalStatus, Reason, controller_words
from bt_orchestrator.model.judging.results import serial_in, too_long, why_duplicate, why_refused
from bt_orchestrator.model.limits import (
    LAST_FEEDBACK_BYTES,
    MESSAGE,
    RESULT_BYTES,
    cut,
    rough_size,
    shortened,
    without_longest,
)
from bt_orchestrator.model.state import CellState, TaskState
from bt_orchestrator.model.words import sentence
from bt_orchestrator.ports import Goal

TIMEOUT = 'timeout'

_REASONS = {
    GoalStatus.ABORTED: Reason.ABORTED,
    GoalStatus.CANCELED: Reason.CANCELED,
    GoalStatus.REJECTED: Reason.GOAL_REJECTED,
    GoalStatus.UNAVAILABLE: Reason.SERVER_UNAVAILABLE,
    GoalStatus.LOST: Reason.SERVER_LOST,
    GoalStatus.SILENT: Reason.IN_DOUBT,
}

_OF_CANCEL = {TIMEOUT: Reason.TIMEOUT, ABORT: Reason.IN_DOUBT}
"""The reason recorded for a cancelled goal, by the cause of the cancel."""


def of_end(state: CellState, key: e.TaskKey, goal: Goal, end: GoalEnd) -> e.TaskEvent:
    """Return the event for the end of a goal (semantics 2.2, 2.3)."""
    task = state.running[key]
    assert task.goal is not None
    fields = {name: value for name, value in end.result.items() if name != TASK_RESULT}
    results = without_longest(fields, RESULT_BYTES)
    left_out = tuple(name for name in fields if name not in results)
    if end.status is not GoalStatus.SUCCEEDED or end.result.get(TASK_RESULT, True) is False:
        return failed(state, key, goal, _reason(task, end), _words(task, end))
    reason, refused = _refusal(state, key, results)
    if reason is not None:
        return failed(state, key, goal, reason, refused, results, left_out)
    return e.TaskSucceeded(
        **key._asdict(),
        attempt=task.attempt,
        goal=task.goal,
        results=results,
        left_out=left_out,
    )


def failed(
    state: CellState,
    key: e.TaskKey,
    goal: Goal,
    reason: Reason,
    message: str,
    results: Mapping[str, Any] | None = None,
    left_out: tuple[str, ...] = (),
) -> e.TaskFailed:
    """Return the event of a failed attempt, with what the controller said and told last.

    :param results: what was refused
    """
    end = goal.end
    return e.TaskFailed(
        **key._asdict(),
        attempt=state.running[key].attempt,
        goal=goal.request.id,
        reason=reason.value,
        message=cut(message, MESSAGE),
        results=results or {},
        left_out=left_out,
        round=state.round(key),
        controller_said=controller_words(end.result) if end else '',
        last_feedback=feedback_text(goal.feedback, LAST_FEEDBACK_BYTES),
        topic_says=end.topic_says if end else '',
        never_begun=end.never_begun if end else False,
    )


def _refusal(
    state: CellState, key: e.TaskKey, results: Mapping[str, Any]
) -> tuple[Reason | None, str]:
    """Say why the results of a task are refused (semantics 2.8, 6.8); None: they are not."""
    task = state.task(key)
    if task is None or key.item is None:
        return None, ''
    serial = serial_in(task, results)
    judges = task.fails_unless is not None  # only then the scope is made
    bad = (why_refused(task, results, state.scope(key)) if judges else None) or too_long(serial)
    if bad:
        return Reason.RESULT_REFUSED, bad
    known = why_duplicate(state, key.item, task, serial)
    return (Reason.DUPLICATE_SERIAL, known) if known else (None, '')


def _words(task: TaskState, end: GoalEnd) -> str:
    if _is_foreign_cancel(task, end):
        who = sentence('foreign_cancel')
    elif task.cancel_cause == ABORT and end.status in _AFTER_ABORT and not end.never_begun:
        who = sentence(_AFTER_ABORT[end.status])
    else:
        return end.message
    return f'{who}; {end.message}' if end.message else who


_AFTER_ABORT = {
    GoalStatus.CANCELED: 'after_abort_canceled',
    GoalStatus.ABORTED: 'after_abort_aborted',
}


def _is_foreign_cancel(task: TaskState, end: GoalEnd) -> bool:
    """Tell whether a goal was cancelled although no orchestrator asked for it (semantics 2.6)."""
    return end.status is GoalStatus.CANCELED and task.cancel_cause is None


def _reason(task: TaskState, end: GoalEnd) -> Reason:
    if end.status is GoalStatus.SUCCEEDED:
        return Reason.TASK_RESULT_FALSE
    if _is_foreign_cancel(task, end):
        return Reason.IN_DOUBT
    if end.status in (GoalStatus.CANCELED, GoalStatus.ABORTED):
        return _OF_CANCEL.get(task.cancel_cause or '', _REASONS[end.status])
    return _REASONS[end.status]


# The last feedback of a goal as text.


def feedback_text(feedback: Mapping[str, Any] | None, most: int) -> str:
    """Return feedback as one JSON object of about `most` bytes; empty: there is none.

    Of a longer one, long fields are shortened, with a mark.
    """
    if feedback is None:
        return ''
    if rough_size(feedback) > most:
        share = most // max(1, len(feedback))
        feedback = {name: shortened(value, share) for name, value in feedback.items()}
    return json_of(feedback)
