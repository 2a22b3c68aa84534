"""Tasks and waits as messages (TaskStatus, PassedTask, Wait), and back."""

from __future__ import annotations

from bt_orchestrator_interfaces import msg

from bt_orchestrator.model.state import End, PassedTask
from bt_orchestrator.model.status import TaskStatus
from bt_orchestrator.model.wait import Wait, WaitKind
from bt_orchestrator.ros.stamps import from_time, to_time

UNKNOWN_S = -1.0


def from_seconds(seconds: float | None) -> float:
    """Return a duration for a message."""
    return UNKNOWN_S if seconds is None else seconds


def to_seconds(value: float) -> float | None:
    """Return a duration of a message; None: it is not known."""
    return None if value < 0.0 else value


def task_message(task: TaskStatus) -> msg.TaskStatus:
    """Return the message about a task in flight."""
    return msg.TaskStatus(
        id=task.id,
        name=task.name,
        component=task.component,
        action=task.action,
        round=task.round,
        attempt=task.attempt,
        goal=task.goal,
        started=to_time(task.started),
        expected_s=from_seconds(task.expected_s),
        feedback=task.feedback,
    )


def task_status(message: msg.TaskStatus) -> TaskStatus:
    """Return what a message says of a task in flight."""
    return TaskStatus(
        id=message.id,
        name=message.name,
        component=message.component,
        action=message.action,
        attempt=message.attempt,
        goal=message.goal,
        started=from_time(message.started),
        expected_s=to_seconds(message.expected_s),
        feedback=message.feedback,
        round=message.round,
    )


def passed_message(task: PassedTask) -> msg.PassedTask:
    """Return the message about a task that was passed."""
    return msg.PassedTask(id=task.id, end=task.end.value, reason=task.reason)


def passed_task(message: msg.PassedTask) -> PassedTask:
    """Return what a message says of a task that was passed."""
    return PassedTask(message.id, End(message.end), message.reason)


def wait_message(wait: Wait) -> msg.Wait:
    """Return the message about a wait."""
    return msg.Wait(
        kind=wait.kind.value,
        name=wait.name,
        sections=wait.sections,
        task=wait.task,
        components=wait.components,
        reason=wait.reason,
    )


def wait_of(message: msg.Wait) -> Wait:
    """Return what a message says of a wait."""
    return Wait(
        reason=message.reason,
        kind=WaitKind(message.kind),
        name=message.name,
        sections=tuple(map(int, message.sections)),
        task=message.task,
        components=tuple(message.components),
    )
