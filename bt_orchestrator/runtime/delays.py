"""Retries that wait for their time (semantics 2.6)."""

from __future__ import annotations

from typing import NamedTuple

from bt_orchestrator.deadlines import has_come
from bt_orchestrator.model.events import TaskKey
from bt_orchestrator.model.script import index_task
from bt_orchestrator.model.state import CellState, Phase
from bt_orchestrator.ports import Clock


class _Delay(NamedTuple):
    not_before: float
    """As it is recorded."""
    until: float
    """On the steady clock."""


class Delays:
    """Until when each retry waits, on a clock that nobody sets.

    What is recorded is a time on the wall clock. How far off it is, is reckoned once, when it is
    asked for first, and never as more than the task's delay.
    """

    def __init__(self, state: CellState, clock: Clock) -> None:
        self._state = state
        self._clock = clock
        self._found: dict[TaskKey, _Delay] = {}

    def left(self, key: TaskKey) -> float | None:
        """Return until when a task waits, on the steady clock; None: it need not wait any more."""
        not_before = self._state.tasks[key].not_before
        found = self._found.get(key)
        if found is None or found.not_before != not_before:
            found = self._found[key] = _Delay(not_before, self._until(key, not_before))
            self._forget()
        return None if has_come(found.until, self._clock.steady()) else found.until

    def _until(self, key: TaskKey, not_before: float) -> float:
        task = self._state.task(key) or index_task(self._state.cell)
        left_s = min(max(not_before - self._clock.now(), 0.0), task.retry_delay_s)
        return self._clock.steady() + left_s

    def _forget(self) -> None:
        tasks = self._state.tasks
        over = [k for k in self._found if k not in tasks or tasks[k].phase is not Phase.RETRYING]
        for key in over:
            del self._found[key]
