"""Attempts of tasks, from start to end, and the tasks that a cycle has passed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from bt_orchestrator.model import events as e
from bt_orchestrator.model.events import TaskKey
from bt_orchestrator.model.hold_words import why_words
from bt_orchestrator.model.state import CellState, Cycle, End, PassedTask, Phase, TaskState


class TaskSpan(NamedTuple):
    """One attempt, from its goal to its end."""

    started: e.TaskStarted
    ended: e.TaskSucceeded | e.TaskFailed

    @property
    def seconds(self) -> float:
        """How long it took."""
        return self.ended.time - self.started.time


class TaskSpans:
    """Takes in one event after another."""

    def __init__(self) -> None:
        self._open: dict[e.TaskKey, e.TaskStarted] = {}

    def follow(self, event: e.Event) -> TaskSpan | None:
        """Take in the next event; returns the attempt that it ends.

        A task may fail without an attempt, for instance because a result is missing. If the clock
        is set, open starts get the time that the new clock would have shown.
        """
        if isinstance(event, e.TaskStarted):
            self._open[event.key] = event
        elif isinstance(event, (e.TaskSucceeded, e.TaskFailed)):
            started = self._open.pop(event.key, None)
            return None if started is None else TaskSpan(started, event)
        elif isinstance(event, e.ClockStepped) and event.seconds:
            for key, span in self._open.items():
                self._open[key] = span.stamped(span.seq, span.time + event.seconds)
        return None

    def open(self) -> Iterator[e.TaskStarted]:
        """Yield the attempts that have not ended, oldest first."""
        yield from self._open.values()

    def start_of(self, event: e.TaskEvent) -> e.TaskStarted | None:
        """Return the start of the attempt that is in flight for a task."""
        return self._open.get(event.key)

    def forget(self) -> None:
        """Forget all starts: later ends pair with no start of before."""
        self._open.clear()


# The tasks that a cycle has passed, and how each ended.

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
