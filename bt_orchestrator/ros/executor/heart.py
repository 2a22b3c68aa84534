"""The causes of a settle: news, the heartbeat and the pulse (architecture, One settle)."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.timer import Timer

from bt_orchestrator.ports.spare_log import guarded
from bt_orchestrator.ros.executor.alarms import steady_timer
from bt_orchestrator.ros.executor.executors import soon


class Heart:
    """Settles as soon as there is something new, and once a second.

    While a settle says that there is more to do, it settles at a steady rate in between. At other
    times it does not: each ring of a timer costs an idle node half a millisecond.

    Everything runs in the executor's one thread. An exception in a settle is logged and counted;
    the next beat tries again.
    """

    def __init__(self, node: Node, executor: Executor) -> None:
        self._node = node
        self._executor = executor
        self._settle: Callable[[], bool] = _nothing
        self._timer: Timer | None = None
        self._scheduled = False
        self.failures = 0
        """How many settles ended with an exception."""

    def start(self, settle: Callable[[], bool], rate_hz: float, pulse: Pulse) -> None:
        """Begin to beat.

        :param settle: tells whether another beat at the steady rate has something to do
        :param rate_hz: this rate
        """
        self._settle = settle
        self._timer = steady_timer(self._node, 1.0 / rate_hz, self.beat)
        pulse.add(self.beat)

    def wake(self) -> None:
        """Settle soon, before the executor waits again."""
        if not self._scheduled:
            self._scheduled = True
            soon(self._executor, self.beat)

    def beat(self) -> None:
        """Settle now."""
        self._scheduled = False
        try:
            goes_on = self._settle()
        except Exception as error:  # noqa: BLE001 - nothing may stop the cell
            self.failures += 1
            self._node.get_logger().error(f'settle failed ({self.failures}): {error!r}')
            goes_on = True
        self._beat_on(wanted=goes_on)

    def _beat_on(self, *, wanted: bool) -> None:
        timer = self._timer
        if timer is None or wanted is not timer.is_canceled():
            return
        if wanted:
            timer.reset()
        else:
            timer.cancel()


def _nothing() -> bool:
    """Stand for the settle until there is an engine."""
    return False


# The work of each second, all in one turn of the executor.

PULSE_S = 1.0


class Pulse:
    """One timer for diagnostics and whatever else looks once a second, in real time.

    Each turn of the executor asks every entity of the node, so an idle node costs what its timers
    ring.
    """

    def __init__(self, node: Node) -> None:
        self._logger = node.get_logger()
        self._callbacks: list[Callable[[], None]] = []
        steady_timer(node, PULSE_S, self._beat)

    def add(self, callback: Callable[[], object]) -> None:
        """Call back once a second from now on; what it raises is reported, and stops nothing."""
        self._callbacks.append(guarded(callback, self._logger))

    def _beat(self) -> None:
        for callback in self._callbacks:
            callback()
