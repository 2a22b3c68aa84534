"""The causes of a settle: the heartbeat timer, and news (architecture, "One settle")."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.executors import Executor
from rclpy.node import Node

from bt_orchestrator.ros.executor.executors import soon
from bt_orchestrator.ros.executor.timers import steady_timer


class Heart:
    """Settles at a steady rate and as soon as there is something new.

    Everything runs in the executor's one thread. An exception in a settle is logged and counted;
    the next beat tries again.
    """

    def __init__(self, node: Node, executor: Executor) -> None:
        self._node = node
        self._executor = executor
        self._settle: Callable[[], object] = _nothing
        self._scheduled = False
        self.failures = 0
        """How many settles ended with an exception."""

    def start(self, settle: Callable[[], object], rate_hz: float) -> None:
        """Begin to beat."""
        self._settle = settle
        steady_timer(self._node, 1.0 / rate_hz, self.beat)

    def wake(self) -> None:
        """Settle soon, before the executor waits again."""
        if not self._scheduled:
            self._scheduled = True
            soon(self._executor, self.beat)

    def beat(self) -> None:
        """Settle now."""
        self._scheduled = False
        try:
            self._settle()
        except Exception as error:  # noqa: BLE001 - nothing may stop the cell
            self.failures += 1
            self._node.get_logger().error(f'settle failed ({self.failures}): {error!r}')


def _nothing() -> None:
    """Stand for the settle until there is an engine."""
