"""The inspection of a tree node: its own server, or that of py_trees_ros."""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Callable
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from rclpy.node import Node

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.ports.spare_log import Logger, guarded
from bt_orchestrator.ros.inspection.snapshot_source import TickStatistics
from bt_orchestrator.ros.node_parameters import BUILTIN

LIBRARY = 'py_trees_ros'


class NoLibrary(OrchestratorError):
    """The parameter asks for py_trees_ros, which cannot be loaded."""


def library_tree(root: Behaviour, node: Any) -> Any:
    """Return a py_trees_ros.trees.BehaviourTree with its services and parameters on a node.

    :raises NoLibrary: it is not installed, or does not work with what is
    """
    try:
        trees = importlib.import_module(f'{LIBRARY}.trees')
    except ImportError as error:
        is_missing = error.name == LIBRARY
        what = 'it is not installed' if is_missing else f'it cannot be loaded: {error}'
        raise NoLibrary(
            f'parameter inspection: {LIBRARY} was asked for, and {what}; install it (apt: '
            f'ros-$ROS_DISTRO-py-trees-ros), or use builtin, to which its watchers attach as well'
        ) from error
    tree = trees.BehaviourTree(root)
    try:
        tree.setup(node=node)
    except Exception as error:
        raise NoLibrary(
            f'parameter inspection: {LIBRARY} cannot be set up: {error}; use builtin, or install '
            f'its packages again, all from one distribution'
        ) from error
    return tree


class LibraryTree:
    """Lets py_trees_ros look at our tree around each settle, as it does around a tick of its own.

    Its `tick` is never called: it would tick the tree at other times and in other parts than the
    engine does. Its handlers and visitors are, with what a tick of all would have gone through;
    only while somebody watches, since they go through the whole tree.
    """

    def __init__(self, tree: Any, root: Callable[[], Behaviour], logger: Logger) -> None:
        """Attach.

        :param tree: a py_trees_ros.trees.BehaviourTree after its setup
        :param root: asked anew each time, as trees may be built anew
        """
        self._tree = tree
        self._root = root
        self._was_watched = False
        self._before = guarded(self._begin, logger)
        self._after = guarded(self._show, logger)

    def around(self, settle: Callable[[], bool]) -> Callable[[], bool]:
        """Return the same call, watched."""

        def call() -> bool:
            is_watched = self._is_watched()
            if is_watched:
                self._before()
            happened = settle()
            if is_watched:
                self._after()
            return happened

        return call

    def _is_watched(self) -> bool:
        # Once more after the last one has left: then it switches the activity stream off.
        exchange = self._tree.blackboard_exchange
        before = self._was_watched
        self._was_watched = bool(self._tree.snapshot_streams or exchange.views)
        return self._was_watched or before

    def _begin(self) -> None:
        for handler in self._tree.pre_tick_handlers:
            handler(self._tree)

    def _show(self) -> None:
        tree = self._tree
        tree.root = self._root()
        for visitor in tree.visitors:
            visitor.initialise()
        for behaviour in tree.root.iterate():
            is_visited = behaviour.status is not Status.INVALID
            for visitor in tree.visitors:
                if visitor.full or is_visited:
                    behaviour.visit(visitor)
        for visitor in tree.visitors:
            visitor.finalise()
        for handler in tree.post_tick_handlers:
            handler(tree)
        tree.count += 1


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
