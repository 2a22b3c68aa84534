"""The tasks that a cycle has passed, and how each ended."""

from __future__ import annotations

from bt_orchestrator.model.events import TaskKey
from bt_orchestrator.model.hold_words import why_words
from bt_orchestrator.model.state import CellState, Cycle, End, PassedTask, Phase, TaskState

_FAILED = (Phase.FAILED, Phase.RETRYING, Phase.HELD)


def passed_tasks(
    state: CellState, section: int, cycle: Cycle
) -> tuple[tuple[PassedTask, ...], tuple[str, ...]]:
    """Return the tasks that a section's cycle has passed, and the ids of those that failed."""
    nonconforming = state.items[cycle.item].nonconforming
    passed, failed = [], []
    for task in state.script(cycle.job).sections[section].tasks:
        progress = state.tasks.get(TaskKey(cycle.job, section, cycle.item, task.id))
        if progress is None:
            continue
        if progress.phase is Phase.DONE:
            is_nonconforming = task.id in nonconforming
            passed.append(passed_task(task.id, progress, is_nonconforming=is_nonconforming))
        has_failed = progress.end is not None and progress.end.is_failure
        if has_failed or task.id in nonconforming or progress.phase in _FAILED:
            failed.append(task.id)
    return tuple(passed), tuple(failed)


def passed_task(task: str, progress: TaskState, *, is_nonconforming: bool = False) -> PassedTask:
    """Return how a task in phase DONE ended.

    :param is_nonconforming: it made its item so; a state of an older version does not say it
    """
    end = progress.end or (End.CONTINUED if is_nonconforming else End.DONE)
    return PassedTask(task, end, _reason(progress))


def _reason(progress: TaskState) -> str:
    if progress.reason is None:
        return progress.message
    return why_words(
        progress.reason.value, progress.message, progress.controller_said, progress.topic_says
    )
