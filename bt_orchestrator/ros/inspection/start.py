"""Starts what tree watchers attach to: the inspection server, or that of py_trees_ros."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable

from rclpy.node import Node

from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.ros.inspection.library_tree import LibraryTree, library_tree
from bt_orchestrator.ros.inspection.tick_statistics import TickStatistics
from bt_orchestrator.ros.node_parameters import BUILTIN

INTERFACES = 'py_trees_ros_interfaces'

Settle = Callable[[], bool]
"""Tells whether anything happened."""


def start_inspection(
    node: Node, orchestrator: Orchestrator, ticks: TickStatistics, kind: str
) -> Callable[[Settle], Settle]:
    """Let tree watchers attach to a node; without their message types, say that they cannot.

    :param kind: value of the parameter `inspection`
    :return: what to wrap each settle in
    :raises NoLibrary: it names py_trees_ros, which cannot be loaded
    """
    if kind != BUILTIN:
        tree = library_tree(orchestrator.tree.root, node)
        logger = node.get_logger().get_child('inspection')
        return LibraryTree(tree, lambda: orchestrator.tree.root, logger).around
    if importlib.util.find_spec(INTERFACES) is None:
        node.get_logger().warning(
            f'no tree watcher can attach: the package {INTERFACES} is not installed '
            '(apt: ros-$ROS_DISTRO-py-trees-ros-interfaces); the cell runs as usual'
        )
        return _as_it_is
    from bt_orchestrator.ros.inspection.server import InspectionServer

    InspectionServer(node, orchestrator, ticks)
    return _as_it_is


def _as_it_is(settle: Settle) -> Settle:
    """Wrap nothing: the inspection server looks between settles."""
    return settle
