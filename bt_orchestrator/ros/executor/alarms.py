"""One timer of a node for any number of deadlines, in real time, whoever sets the clock."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from rclpy.timer import Timer

from bt_orchestrator.base.deadlines import NS_PER_S, Deadline, Deadlines
from bt_orchestrator.ports.spare_log import guarded

_FAR_S = 3600.0
"""First period of the timer, which is never waited for."""


class Alarms:
    """Calls back at given times; what a callback raises is reported, and stops nothing.

    An executor looks at every timer in every turn, and gathers all entities anew when a timer is
    made or destroyed; so there is one for all. It is started anew only for a deadline earlier
    than the one it waits for; a cancelled one may thus ring for nothing. To be used in the
    executor's thread.
    """

    def __init__(
        self,
        node: Node,
        now_ns: Callable[[], int] = time.monotonic_ns,
        make_timer: MakeTimer | None = None,
    ) -> None:
        """Wait for nothing yet.

        :param now_ns: returns the time of the clock on which the timer is made
        :param make_timer: makes a timer from a period in seconds and a callback; None: one on the
            steady clock
        """
        self._node = node
        self._now_ns = now_ns
        self._logger = node.get_logger()
        self._deadlines = Deadlines()
        self._armed_ns: int | None = None
        self._timer = (make_timer or partial(steady_timer, node))(_FAR_S, self._ring)
        self._timer.cancel()

    def call_at(self, time_ns: int, callback: Callable[[], None]) -> Deadline:
        """Call back once a time has come; never before this call has returned."""
        deadline = self._deadlines.add(time_ns, callback)
        if self._armed_ns is None or deadline.time_ns < self._armed_ns:
            self._arm(deadline.time_ns)
        return deadline

    def call_after(self, seconds: float, callback: Callable[[], None]) -> Deadline:
        """Call back after a time."""
        return self.call_at(self._now_ns() + round(seconds * NS_PER_S), callback)

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


# Timers that ring in real time, whoever sets the clock.

MakeTimer = Callable[[float, Callable[[], None]], Timer]
"""Makes a timer from its period in seconds and its callback."""


def steady_timer(node: Node, period_s: float, callback: Callable[[], None]) -> Timer:
    """Make a timer of a node on the steady clock.

    A timer on the clock of a node goes by the wall clock: set an hour back, it is silent for that
    hour. With `use_sim_time` it stands while nobody publishes the time.
    """
    return node.create_timer(period_s, callback, clock=Clock(clock_type=ClockType.STEADY_TIME))
