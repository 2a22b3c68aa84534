"""The time of a node, as a port."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from typing import Any, cast

from rclpy.node import Node

from bt_orchestrator.deadlines import NS_PER_S, Deadline, Deadlines, instant_ns
from bt_orchestrator.model.uptime import Uptime
from bt_orchestrator.ros.executor.callbacks import guarded
from bt_orchestrator.ros.executor.timers import steady_timer
from bt_orchestrator.ros.uptime import MachineUptime

_FAR_S = 3600.0
"""First period of the timer, which is never waited for."""


class RosClock:
    """System time, or simulated time with `use_sim_time`. Implements `ports.Clock`.

    Deadlines are on the steady clock, for the system's is set by people and by NTP. Where a node
    begins with `use_sim_time` they are in simulated time, which its simulation alone sets.

    One timer for all deadlines, since an executor looks at every timer in every turn. It is
    started anew only for a deadline earlier than the one it waits for; a cancelled one may thus
    ring for nothing. To be used in the executor's thread.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._clock = cast('Any', node.get_clock())
        self._logger = node.get_logger()
        self._is_simulated = bool(self._clock.ros_time_is_active)
        self._uptime = MachineUptime()
        self._deadlines = Deadlines()
        self._armed_ns: int | None = None
        make_timer = node.create_timer if self._is_simulated else partial(steady_timer, node)
        self._timer = make_timer(_FAR_S, self._ring)
        self._timer.cancel()

    def now(self) -> float:
        """Return seconds since the epoch, or the simulated time."""
        if self._is_simulated:
            return float(self._clock.now().nanoseconds / NS_PER_S)
        return time.time()  # the same, at a tenth of the cost

    def steady(self) -> float:
        """Return seconds of the steady clock, or the simulated time."""
        return self._steady_ns() / NS_PER_S

    def uptime(self) -> Uptime | None:
        """Return how long the machine has been up; None with simulated time."""
        return None if self._is_simulated else self._uptime.now()

    def call_at(self, time: float, callback: Callable[[], None]) -> Deadline:
        """Call back once `steady()` has reached a time; never before this call has returned."""
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
        now_ns = self._steady_ns()
        while callback := self._deadlines.pop_due(now_ns):
            guarded(callback, self._logger)()
        due_ns = self._deadlines.next_ns()
        if due_ns is not None:
            self._arm(due_ns)

    def _arm(self, due_ns: int) -> None:
        self._armed_ns = due_ns
        self._timer.timer_period_ns = max(due_ns - self._steady_ns(), 0)
        self._timer.reset()

    def _steady_ns(self) -> int:
        return int(self._clock.now().nanoseconds) if self._is_simulated else time.monotonic_ns()
