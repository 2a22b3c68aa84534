"""Which action servers there are on the ROS graph."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress

import rclpy
from rclpy.action.graph import get_action_server_names_and_types_by_node
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node, NodeNameNonExistentError
from rclpy.signals import SignalHandlerOptions

from bt_orchestrator.errors import OrchestratorError
from bt_orchestrator.script.starter_plan import FoundServer

STEP_S = 0.1

SETTLE_S = 1.5
"""How long nothing new may have come before the graph counts as known."""

_STATE_TYPE = 'std_msgs/msg/String'


class NobodyServes(OrchestratorError):
    """There is no action server on the graph."""


def find_action_servers(timeout_s: float) -> Sequence[FoundServer]:
    """Join the ROS graph for a moment and return its action servers.

    :param timeout_s: longest time to wait for a first one, and for the last one
    :raises NobodyServes: none was found
    """
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = Node('bt_orchestrator_new_cell', start_parameter_services=False, enable_rosout=False)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    try:
        return _settled(lambda: [*_servers(node)], executor, timeout_s)
    finally:
        executor.shutdown()
        node.destroy_node()
        rclpy.try_shutdown()


def _settled(
    look: Callable[[], list[FoundServer]], executor: SingleThreadedExecutor, timeout_s: float
) -> list[FoundServer]:
    """Look until nothing new has come for a while."""
    found: list[FoundServer] = []
    changed = started = time.monotonic()
    while time.monotonic() < started + timeout_s:
        now_found = look()
        if now_found != found:
            found, changed = now_found, time.monotonic()
        if found and time.monotonic() > changed + SETTLE_S:
            break
        executor.spin_once(timeout_sec=STEP_S)
    if not found:
        raise NobodyServes(
            f'no action server was found within {timeout_s:g} s; start the controllers, with this '
            'ROS_DOMAIN_ID, or leave out --from-graph'
        )
    return found


def _servers(node: Node) -> Iterator[FoundServer]:
    topics = [name for name, types in node.get_topic_names_and_types() if _STATE_TYPE in types]
    for name, namespace in sorted(set(node.get_node_names_and_namespaces())):
        # A node may have left between the two questions.
        with suppress(NodeNameNonExistentError):
            served = get_action_server_names_and_types_by_node(node, name, namespace)
            for action, types in served:
                full_name = f'{namespace.rstrip("/")}/{name}'
                yield FoundServer(action, types[0], full_name, _beside(action, topics))


def _beside(action: str, topics: Sequence[str]) -> tuple[str, ...]:
    """Return the topics of an action's own namespace that are called state or status."""
    folder = action.rpartition('/')[0]
    likely = (f'{folder}/{word}' for word in ('state', 'status') if folder)
    return tuple(topic for topic in likely if topic in topics)
