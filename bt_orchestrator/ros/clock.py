"""The time of a node, as a port."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, cast

from rclpy.node import Node

from bt_orchestrator.base.deadlines import NS_PER_S, Deadline, instant_ns
from bt_orchestrator.model.uptime import Uptime
from bt_orchestrator.ros.executor.alarms import Alarms
from bt_orchestrator.ros.uptime import MachineUptime


class RosClock:
    """System time, or simulated time with `use_sim_time`. Implements `ports.Clock`.

    Deadlines are on the steady clock, for the system's is set by people and by NTP. Where a node
    begins with `use_sim_time` they are in simulated time, which its simulation alone sets.

    To be used in the executor's thread.
    """

    def __init__(self, node: Node) -> None:
        self._clock = cast('Any', node.get_clock())
        self._is_simulated = bool(self._clock.ros_time_is_active)
        self._uptime = MachineUptime()
        make_timer = node.create_timer if self._is_simulated else None
        self._alarms = Alarms(node, self._steady_ns, make_timer)

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
        return self._alarms.call_at(instant_ns(time), callback)

    def close(self) -> None:
        """Forget all deadlines."""
        self._alarms.close()

    def _steady_ns(self) -> int:
        return int(self._clock.now().nanoseconds) if self._is_simulated else time.monotonic_ns()
