"""The `Clock` port on a ROS 2 node: any number of deadlines on one ROS timer."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node

from bt_orchestrator.base.deadlines import NS_PER_S, Deadline, Deadlines, instant_ns
from bt_orchestrator.model.uptime import Uptime
from bt_orchestrator.sim.controllers.guard import guarded

_FAR_S = 3600.0


class NodeClock:
    """Time of a node: the system's, or simulated with `use_sim_time`. Implements `ports.Clock`.

    Deadlines are on the steady clock, or in simulated time if the node begins with that.

    One timer for all, because every ROS timer is looked at in every turn of the executor. To be
    used in the executor's thread only.
    """

    def __init__(self, node: Node) -> None:
        self._clock = cast('Any', node.get_clock())
        self._steady = self._clock
        if not self._clock.ros_time_is_active:
            self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._logger = node.get_logger()
        self._deadlines = Deadlines()
        self._timer = node.create_timer(_FAR_S, self._ring, clock=self._steady, autostart=False)

    def now(self) -> float:
        """Return seconds since the epoch, or the simulated time."""
        return int(self._clock.now().nanoseconds) / NS_PER_S

    def steady(self) -> float:
        """Return seconds of the steady clock, or the simulated time."""
        return self._steady_ns() / NS_PER_S

    def uptime(self) -> Uptime | None:
        """Return None: simulated controllers do not use it."""
        return None

    def call_at(self, time: float, callback: Callable[[], None]) -> Deadline:
        """Call back once `steady()` has reached a time; never before this call has returned."""
        deadline = self._deadlines.add(instant_ns(time), callback)
        self._arm()
        return deadline

    def _ring(self) -> None:
        self._timer.cancel()
        now_ns = self._steady_ns()
        while callback := self._deadlines.pop_due(now_ns):
            guarded(callback, self._logger)
        self._arm()

    def _arm(self) -> None:
        due_ns = self._deadlines.next_ns()
        if due_ns is None:
            self._timer.cancel()
            return
        self._timer.timer_period_ns = max(due_ns - self._steady_ns(), 0)
        self._timer.reset()

    def _steady_ns(self) -> int:
        return int(self._steady.now().nanoseconds)
