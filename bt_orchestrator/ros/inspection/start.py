"""Starts the inspection server, if its message types are installed."""

from __future__ import annotations

import importlib.util

from rclpy.node import Node

from bt_orchestrator.ros.inspection.parameters import declare_kind
from bt_orchestrator.ros.inspection.tick_statistics import TickStatistics
from bt_orchestrator.runtime.orchestrator import Orchestrator

INTERFACES = 'py_trees_ros_interfaces'


def start_inspection(node: Node, orchestrator: Orchestrator, ticks: TickStatistics) -> None:
    """Let tree watchers attach to a node; without their message types, say that they cannot.

    :raises UnknownInspection: the parameter `inspection` names none that there is
    """
    declare_kind(node)
    if importlib.util.find_spec(INTERFACES) is None:
        node.get_logger().warning(
            f'no tree watcher can attach: the package {INTERFACES} is not installed '
            '(apt: ros-$ROS_DISTRO-py-trees-ros-interfaces); the cell runs as usual'
        )
        return
    from bt_orchestrator.ros.inspection.server import InspectionServer

    InspectionServer(node, orchestrator, ticks)
