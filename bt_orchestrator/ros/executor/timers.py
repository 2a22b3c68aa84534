"""Timers that ring in real time, whoever sets the clock."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from rclpy.timer import Timer

MakeTimer = Callable[[float, Callable[[], None]], Timer]
"""Makes a timer from its period in seconds and its callback."""


def steady_timer(node: Node, period_s: float, callback: Callable[[], None]) -> Timer:
    """Make a timer of a node on the steady clock.

    A timer on the clock of a node goes by the wall clock: set an hour back, it is silent for that
    hour. With `use_sim_time` it stands while nobody publishes the time.
    """
    return node.create_timer(period_s, callback, clock=Clock(clock_type=ClockType.STEADY_TIME))
