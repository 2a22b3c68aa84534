"""Quality of service, by what a topic is for."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

LATCHED = QoSProfile(
    depth=1,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)
"""The last value, also for later subscribers: the status."""

EVENTS = QoSProfile(depth=1000, reliability=ReliabilityPolicy.RELIABLE)
"""Every record, in order; 1000 is more than a settle of a large cell makes."""


SERVICES = QoSProfile(depth=100, reliability=ReliabilityPolicy.RELIABLE)
"""Requests and answers; ROS 2 keeps 10 by default.

A service has one such queue for the requests of all its clients. Each answer goes to every client,
which picks out its own; what does not fit replaces the oldest, and nobody is told. So 10 are too
few as soon as a process is busy for a tenth of a second while clients ask. 100 answers of the
longest kind (`limits.EVENTS_BYTES`) are 100 MB, kept while a client that hangs does not take them.
"""


def create_client(node: Node, kind: Any, name: str) -> Any:
    """Create a client of a service that others ask too."""
    return node.create_client(kind, name, qos_profile=SERVICES)


def publisher(node: Node, kind: Any, name: str, qos: QoSProfile | int) -> Any:
    """Create a publisher without rclpy's handlers of its events.

    They only log that a subscription does not fit, which the subscriber's side does too, and each
    of them is asked in every turn of the executor.
    """
    quiet = PublisherEventCallbacks(use_default_callbacks=False)
    return node.create_publisher(kind, name, qos, event_callbacks=quiet)


def quieten(node: Node) -> None:
    """Take rclpy's handlers of events from the publishers that it has given a node itself."""
    for own in node.publishers:
        for handler in own.event_handlers:
            node.remove_waitable(handler)
        own.event_handlers.clear()  # or rclpy would remove them once more


def subscribe(
    node: Node, kind: Any, name: str, callback: Callable[[Any], None], qos: QoSProfile
) -> Any:
    """Return a subscription, likewise without rclpy's handlers of events."""
    quiet = SubscriptionEventCallbacks(use_default_callbacks=False)
    return node.create_subscription(kind, name, callback, qos, event_callbacks=quiet)
