"""The work of each second, all in one turn of the executor."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.node import Node

from bt_orchestrator.ros.executor.callbacks import guarded
from bt_orchestrator.ros.executor.timers import steady_timer

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
