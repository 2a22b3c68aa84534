"""Delays of retries (semantics 2.6)."""

from __future__ import annotations

from typing import NamedTuple

from bt_orchestrator.base.deadlines import has_come
from bt_orchestrator.model.events import TaskKey
from bt_orchestrator.model.script import index_task
from bt_orchestrator.model.state import CellState, Phase
from bt_orchestrator.model.uptime import seconds_between
from bt_orchestrator.ports import Clock


class _Delay(NamedTuple):
    not_before: float
    """As recorded, on the wall clock."""
    until: float
    """On the steady clock."""


class Delays:
    """The end of each retry's delay, on the steady clock.

    The remaining time is computed once, at the first request, from the machine's uptime. After a
    boot, or on another machine, the delay begins anew. If no uptime was recorded, the wall clock
    is used, for no more than the task's delay.
    """

    def __init__(self, state: CellState, clock: Clock) -> None:
        self._state = state
        self._clock = clock
        self._found: dict[TaskKey, _Delay] = {}

    def left(self, key: TaskKey) -> float | None:
        """Return until when a task waits, on the steady clock; None: its delay is over."""
        not_before = self._state.tasks[key].not_before
        found = self._found.get(key)
        if found is None or found.not_before != not_before:
            found = self._found[key] = _Delay(not_before, self._until(key, not_before))
            self._forget()
        return None if has_come(found.until, self._clock.steady()) else found.until

    def _until(self, key: TaskKey, not_before: float) -> float:
        decided = self._state.tasks[key]
        ago_s = seconds_between(decided.delayed_up, self._clock.uptime())
        if ago_s is not None:
            return self._clock.steady() + decided.delay_s - ago_s
        if decided.delayed_up is not None:
            return self._clock.steady() + decided.delay_s
        task = self._state.task(key) or index_task(self._state.cell)
        left_s = min(max(not_before - self._clock.now(), 0.0), task.retry_delay_s)
        return self._clock.steady() + left_s

    def _forget(self) -> None:
        tasks = self._state.tasks
        over = [k for k in self._found if k not in tasks or tasks[k].phase is not Phase.RETRYING]
        for key in over:
            del self._found[key]
