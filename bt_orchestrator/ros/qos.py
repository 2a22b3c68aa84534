"""Quality of service, by what a topic is for."""

from __future__ import annotations

from typing import Any

from rclpy.event_handler import PublisherEventCallbacks
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

LATCHED = QoSProfile(
    depth=1,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)
"""The last value, also for those who come later: the status."""

EVENTS = QoSProfile(depth=1000, reliability=ReliabilityPolicy.RELIABLE)
"""Every record, in order; 1000 is more than a settle of a large cell makes."""


def publisher(node: Node, kind: Any, name: str, qos: QoSProfile | int) -> Any:
    """Create a publisher without rclpy's handlers of its events.

    They only log that a subscription does not fit, which the subscriber's side does too, and each
    of them is asked in every turn of the executor.
    """
    quiet = PublisherEventCallbacks(use_default_callbacks=False)
    return node.create_publisher(kind, name, qos, event_callbacks=quiet)
