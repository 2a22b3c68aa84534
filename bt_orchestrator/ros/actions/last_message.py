"""A topic whose last message only is read, and only on demand."""

from __future__ import annotations

from typing import Any

from rclpy.node import Node
from rclpy.qos import QoSProfile

from bt_orchestrator.ros.executor.handles import subscription


class LastMessage:
    """A subscription outside the wait set: its last message stays until it is read."""

    def __init__(self, node: Node, message_class: Any, topic: str, qos: QoSProfile) -> None:
        """Subscribe; the topic's name is remapped as any other.

        :param qos: of depth 1
        """
        self._class = message_class
        self._handle = subscription(node, message_class, topic, qos)
        self._last: Any = None

    @property
    def publishers(self) -> int:
        """How many are connected; costs next to nothing."""
        with self._handle:
            return int(self._handle.get_publisher_count())

    def read(self) -> Any:
        """Return the last message, the same one again until another came; None: none came."""
        with self._handle:
            while (taken := self._handle.take_message(self._class, False)) is not None:
                self._last = taken[0]
        return self._last

    def destroy(self) -> None:
        """End the subscription."""
        self._handle.destroy_when_not_in_use()
