"""The ROS graph as one participant sees it, and its action servers, after time for discovery."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.expand_topic_name import expand_topic_name
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.topic_endpoint_info import TopicEndpointInfo

from bt_orchestrator.base.diagnosis.ros_environment import hear_of_all
from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.ros.actions.rivals import names
from bt_orchestrator.ros.identity import twins_in_words
from bt_orchestrator.ros.qos import LATCHED, create_client
from bt_orchestrator.script.starter.starter_plan import FoundServer

STEP_S = 0.1

SETTLE_S = 3.5
"""How long to look at least: a second server or node may be found later than the first. Where
discovery is limited to one computer, a participant may hear of another after 3 s only."""

OWN_NAME = 'bt_orchestrator_doctor'


class Graph:
    """A look at who is there. A context: entering joins the ROS graph, leaving leaves it."""

    def __init__(self, namespace: str, settle_s: float = SETTLE_S) -> None:
        """Prepare.

        :param namespace: in which relative names are meant
        :param settle_s: how long to look at least
        """
        self._namespace = namespace
        self._settle_s = settle_s

    def __enter__(self) -> Graph:
        hear_of_all(os.environ)
        rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
        self._node = Node(OWN_NAME, start_parameter_services=False, enable_rosout=False)
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self._node)
        self._joined = time.monotonic()
        return self

    def __exit__(self, *exception: object) -> None:
        self._executor.shutdown()
        self._node.destroy_node()
        rclpy.try_shutdown()

    def wait(self, condition: Callable[[], bool], timeout_s: float) -> bool:
        """Spin until a condition holds; tell whether it does."""
        deadline = time.monotonic() + timeout_s
        while not condition():
            if time.monotonic() >= deadline:
                return False
            self._executor.spin_once(timeout_sec=STEP_S)
        return True

    def settle(self) -> None:
        """Look on until it has looked long enough since it joined the graph."""
        self.wait(lambda: False, self._joined + self._settle_s - time.monotonic())

    def topics(self) -> dict[str, Sequence[str]]:
        """Return the types of all topics, those of actions too."""
        return dict(self._node.get_topic_names_and_types())

    def publishers(self, name: str) -> Sequence[TopicEndpointInfo]:
        """Return who publishes on a topic, relative names expanded."""
        return self._node.get_publishers_info_by_topic(self.full(name))

    def action_servers(self, action: str) -> Sequence[TopicEndpointInfo]:
        """Return the feedback publishers of an action: one a server, with the action's type."""
        return self.publishers(f'{action}/_action/feedback')

    def action_takers(self, action: str) -> int:
        """Count who takes goals of an action: one that lacks the topics of a server does too."""
        return int(self._node.count_services(self.full(f'{action}/_action/send_goal')))

    def full(self, name: str) -> str:
        """Return the full name of what a cell file names."""
        return str(expand_topic_name(name, OWN_NAME, self._namespace))

    def nodes(self) -> list[str]:
        """Return the full names of all nodes, each as often as it is there."""
        pairs = self._node.get_node_names_and_namespaces()
        return [f'{namespace.rstrip("/")}/{name}' for name, namespace in pairs]

    def twins(self, name: str) -> str:
        """Say where all are that answer as a tree node of a name, if there are several."""
        return twins_in_words(self._node, name)

    def latched(self, kind: Any, topic: str, timeout_s: float) -> Any:
        """Return the last message of a latched topic; None if none comes in time."""
        received: list[Any] = []
        subscription = self._node.create_subscription(kind, topic, received.append, LATCHED)
        try:
            self.wait(lambda: bool(received), timeout_s)
        finally:
            self._node.destroy_subscription(subscription)
        return received[-1] if received else None

    def call(self, kind: Any, service: str, request: Any, timeout_s: float) -> Any:
        """Call a service; None if it does not answer in time."""
        client: Any = create_client(self._node, kind, service)
        if not self.wait(client.service_is_ready, timeout_s):
            return None
        future = client.call_async(request)
        return future.result() if self.wait(future.done, timeout_s) else None


# The action servers on the ROS graph.

_FEEDBACK = '/_action/feedback'
_FEEDBACK_TYPE = '_FeedbackMessage'
_STATE_TYPE = 'std_msgs/msg/String'

_NO_DEVICE = 'bt_orchestrator_interfaces/action/RunJob'
"""The services of a tree node that runs beside the controllers."""


class NobodyServes(OrchestratorError):
    """There is no action server on the graph."""


def find_action_servers(timeout_s: float) -> Sequence[FoundServer]:
    """Join the ROS graph for a moment and return its action servers.

    :param timeout_s: longest time to wait for a first one, and for the last one
    :raises NobodyServes: none was found
    """
    with Graph('/') as graph:
        look = _Look(graph)
        graph.wait(look.is_settled, timeout_s)
    if not look.found:
        raise NobodyServes(
            f'no action server was found within {timeout_s:g} s; start the controllers, with this '
            'ROS_DOMAIN_ID, or leave out --from-graph'
        )
    return look.found


class _Look:
    """The content of the graph, and its time."""

    def __init__(self, graph: Graph) -> None:
        self._graph = graph
        self._since = time.monotonic()
        self.found: list[FoundServer] = []

    def is_settled(self) -> bool:
        """Look again; tell whether there is something, and nothing new for a while."""
        servers = [*_servers(self._graph)]
        if servers != self.found:
            self.found, self._since = servers, time.monotonic()
        return bool(servers) and time.monotonic() > self._since + SETTLE_S


def _servers(graph: Graph) -> Iterator[FoundServer]:
    """Yield who publishes feedback: node names do not tell two nodes of one name apart."""
    topics = graph.topics()
    states = [name for name, types in topics.items() if _STATE_TYPE in types]
    for topic in sorted(topics):
        action = topic.removesuffix(_FEEDBACK)
        served = graph.action_servers(action) if action != topic else ()
        type_name = served[0].topic_type.removesuffix(_FEEDBACK_TYPE) if served else _NO_DEVICE
        if type_name != _NO_DEVICE:
            yield FoundServer(action, type_name, names(served), _beside(action, states))


def _beside(action: str, topics: Sequence[str]) -> tuple[str, ...]:
    """Return the topics of an action's own namespace that are called state or status."""
    folder = action.rpartition('/')[0]
    likely = (f'{folder}/{word}' for word in ('state', 'status') if folder)
    return tuple(topic for topic in likely if topic in topics)
