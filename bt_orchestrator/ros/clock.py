"""The time of a node, as a port."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from rclpy.node import Node

from bt_orchestrator.deadlines import NS_PER_S, Deadline, Deadlines, instant_ns
from bt_orchestrator.ros.callbacks import guarded

_FAR_S = 3600.0
"""First period of the timer, which is never waited for."""


class RosClock:
    """System time, or simulated time with `use_sim_time`. Implements `ports.Clock`.

    One timer for all deadlines, since an executor looks at every timer in every turn. It is
    started anew only for a deadline earlier than the one it waits for; a cancelled one may thus
    ring for nothing. To be used in the executor's thread.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._clock: Any = node.get_clock()
        self._logger = node.get_logger()
        self._deadlines = Deadlines()
        self._armed_ns: int | None = None
        self._timer = node.create_timer(_FAR_S, self._ring)
        self._timer.cancel()

    def now(self) -> float:
        """Return seconds since the epoch, or the simulated time."""
        return self._now_ns() / NS_PER_S

    def call_at(self, time: float, callback: Callable[[], None]) -> Deadline:
        """Call back once `now()` has reached a time; never before this call has returned."""
        deadline = self._deadlines.add(instant_ns(time), callback)
        if self._armed_ns is None or deadline.time_ns < self._armed_ns:
            self._arm(deadline.time_ns)
        return deadline

    def close(self) -> None:
        """Forget all deadlines."""
        self._deadlines = Deadlines()
        self._node.destroy_timer(self._timer)

    def _ring(self) -> None:
        self._timer.cancel()
        self._armed_ns = None
        now_ns = self._now_ns()
        while callback := self._deadlines.pop_due(now_ns):
            guarded(callback, self._logger)()
        due_ns = self._deadlines.next_ns()
        if due_ns is not None:
            self._arm(due_ns)

    def _arm(self, due_ns: int) -> None:
        self._armed_ns = due_ns
        self._timer.timer_period_ns = max(due_ns - self._now_ns(), 0)
        self._timer.reset()

    def _now_ns(self) -> int:
        if self._clock.ros_time_is_active:
            return int(self._clock.now().nanoseconds)
        return time.time_ns()  # the same, at a tenth of the cost
