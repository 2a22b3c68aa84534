"""What makes the engine settle: the heartbeat timer, and news (architecture, "One settle")."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.timer import Timer

from bt_orchestrator.ros.executor.executors import soon
from bt_orchestrator.ros.executor.timers import steady_timer

AT_LEAST_S = 1.0
"""Longest time between two rings on a line that settles all the time: housekeeping waits for a
settle that finds nothing."""


class Heart:
    """Settles as soon as there is something new, and a period after the last settle.

    A ring of the timer is a wait and a turn of the executor more, so there is none where another
    settle has just looked at everything. All runs in the executor's one thread. An exception in a
    settle is logged and counted; the next beat tries again.
    """

    def __init__(self, node: Node, executor: Executor) -> None:
        self._node = node
        self._executor = executor
        self._settle: Callable[[], object] = _nothing
        self._scheduled = False
        self._timer: Timer | None = None
        self._rang_s = -math.inf
        self.failures = 0
        """How many settles ended with an exception."""

    def start(self, settle: Callable[[], object], rate_hz: float) -> None:
        """Begin to beat."""
        self._settle = settle
        self._timer = steady_timer(self._node, 1.0 / rate_hz, self._ring)

    def wake(self) -> None:
        """Settle soon, before the executor waits again."""
        if not self._scheduled:
            self._scheduled = True
            soon(self._executor, self.beat)

    def beat(self) -> None:
        """Settle now."""
        self._scheduled = False
        if self._timer is not None and time.monotonic() - self._rang_s < AT_LEAST_S:
            self._timer.reset()
        try:
            self._settle()
        except Exception as error:  # noqa: BLE001 - nothing may stop the cell
            self.failures += 1
            self._node.get_logger().error(f'settle failed ({self.failures}): {error!r}')

    def _ring(self) -> None:
        self._rang_s = time.monotonic()
        self.beat()


def _nothing() -> None:
    """Stand for the settle until there is an engine."""
