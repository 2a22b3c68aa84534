"""Subscriptions and service clients as rclpy has them inside: no executor knows of them.

Only this, `lean_executor` and `wait_list` know rclpy's inside.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.type_support import check_for_type_support

from bt_orchestrator.ros.qos import SERVICES


def subscription(node: Node, message_class: Any, topic: str, qos: QoSProfile) -> Any:
    """Return a subscription's handle: used within `with`, and destroyed when not in use."""
    check_for_type_support(message_class)
    profile: Any = qos.get_c_qos_profile()
    with node.handle:
        return _rclpy.Subscription(node.handle, message_class, topic, profile)


def count_services(node: Node, full_name: str) -> int:
    """Count the servers of a service in the ROS graph.

    rclpy's own method works the name out and proves it each time, which takes longer.
    """
    with node.handle:
        counted: Any = node.handle
        return int(counted.get_count_services(full_name))


def publisher_ids(node: Node, full_name: str) -> Sequence[str]:
    """Return an id of each publisher of a topic in the ROS graph; no other endpoint has it.

    rclpy's own method makes objects of all that is known of each, which takes far longer.
    """
    with node.handle:
        known: Any = _rclpy.rclpy_get_publishers_info_by_topic(node.handle, full_name, False)
    return [id_of(one['endpoint_gid']) for one in known]


def id_of(gid: Sequence[int]) -> str:
    """Return the id of an endpoint as text."""
    return bytes(gid).hex()


def service_client(node: Node, service_class: Any, name: str) -> Any:
    """Return a service client's handle: used within `with`, and destroyed when not in use."""
    check_for_type_support(service_class)
    profile: Any = SERVICES.get_c_qos_profile()
    with node.handle:
        return _rclpy.Client(node.handle, service_class, name, profile)
