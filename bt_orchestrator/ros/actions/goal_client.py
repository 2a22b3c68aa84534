"""An action client made of its parts, which can ask for a result again by UUID.

An action is three services and two topics (design.ros2.org, article "Actions").
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from action_msgs.msg import GoalInfo, GoalStatus, GoalStatusArray
from action_msgs.srv import CancelGoal
from rclpy.node import Node
from rclpy.qos import QoSProfile, qos_profile_action_status_default
from rclpy.topic_endpoint_info import TopicEndpointInfo
from rclpy.type_support import check_for_type_support
from unique_identifier_msgs.msg import UUID

from bt_orchestrator.ros.executor.ways import Answered, Connections, Question, Service, Way

_ACTIVE = (GoalStatus.STATUS_ACCEPTED, GoalStatus.STATUS_EXECUTING, GoalStatus.STATUS_CANCELING)


GRAPH_S = 1.0
"""How much later than a connection the ROS graph may know of a publisher."""


def own_endpoint(node: Node, topic: str) -> Sequence[int]:
    """Return the id of a node's own subscription to a topic; empty: the graph does not tell."""
    for endpoint in node.get_subscriptions_info_by_topic(topic):
        if endpoint.node_name == node.get_name():
            return tuple(endpoint.endpoint_gid)
    return ()


def endpoint_id(endpoint: TopicEndpointInfo) -> str:
    """Return an id that no other endpoint has."""
    return bytes(endpoint.endpoint_gid).hex()


class ServerStatus:
    """The last message of its status topic, which is latched and lists all that it remembers.

    A server publishes it three times a goal, the last time just before the result: it is read
    when somebody asks.
    """

    def __init__(self, node: Node, action: str, way: Way) -> None:
        self._node = node
        self._name = f'{action}/_action/status'
        self._topic = way.last_message(
            node, GoalStatusArray, self._name, qos_profile_action_status_default
        )
        self._id: str | None = None
        self._connections: Connections | None = None
        self._changed_s = -math.inf
        self._is_told = False
        """The graph had as many publishers as are connected, long after one came or went."""
        self._read: Any = None
        self._listed: Mapping[bytes, int] = {}
        self._stamps: Mapping[bytes, Any] = {}

    @property
    def is_published(self) -> bool:
        """Tell whether a publisher is connected; costs next to nothing."""
        return self.publishers > 0

    @property
    def publishers(self) -> int:
        """How many publishers are connected; costs next to nothing."""
        return self._topic.publishers

    def publishers_info(self) -> Sequence[TopicEndpointInfo]:
        """Return who publishes it. Takes a tenth of a millisecond."""
        return self._node.get_publishers_info_by_topic(self._name)

    def own_endpoint(self) -> Sequence[int]:
        """Return the id of this node's own subscription to it; empty: the graph does not tell."""
        return own_endpoint(self._node, self._name)

    def publisher_id(self) -> str | None:
        """Return an id of the publisher, which no other instance of the server has.

        None: there is no server, or more than one. Goes through the whole ROS graph unless it is
        known that no publisher has come or gone in the last second.
        """
        now = time.monotonic()
        connections = self._topic.connections  # first: what comes meanwhile is seen next time
        if connections != self._connections:
            self._connections, self._changed_s, self._is_told = connections, now, False
        if not self._is_told:
            ids = [endpoint_id(publisher) for publisher in self.publishers_info()]
            self._id = ids[0] if len(ids) == 1 else None
            is_alike = connections is not None and connections.now == len(ids)
            self._is_told = is_alike and now - self._changed_s > GRAPH_S
        return self._id

    def of(self, goal_id: UUID) -> int | None:
        """Return a goal's status (action_msgs/GoalStatus); None: it is not listed.

        A goal that is listed was accepted, whatever became of the answer. Of one that ended the
        server may know no more than this topic still says.
        """
        return self._by_goal().get(bytes(goal_id.uuid))

    def is_active(self, goal_id: UUID) -> bool:
        """Tell whether a goal runs."""
        return self.of(goal_id) in _ACTIVE

    def active(self) -> Iterator[bytes]:
        """Yield the ids of the goals that run, anybody's."""
        return (goal for goal, status in self._by_goal().items() if status in _ACTIVE)

    def accepted_s(self, goal_id: bytes) -> float:
        """Return when a goal that is listed was accepted, in seconds by the server's clock."""
        stamp = self._stamps[goal_id]
        return float(stamp.sec + stamp.nanosec * 1e-9)

    @property
    def is_busy(self) -> bool:
        """Tell whether any goal runs, anybody's.

        Such a server may be silent for long: it answers for a goal at its end, and one that works
        in the thread of its callbacks answers nothing meanwhile.
        """
        return any(self.active())

    def destroy(self) -> None:
        """End the subscription."""
        self._topic.destroy()

    def _by_goal(self) -> Mapping[bytes, int]:
        message = self._topic.read()
        if message is not self._read:
            self._read = message
            infos = [(bytes(info.goal_info.goal_id.uuid), info) for info in message.status_list]
            self._listed = {goal: info.status for goal, info in infos}
            self._stamps = {goal: info.goal_info.stamp for goal, info in infos}
        return self._listed


class GoalClient:
    """Does what rclpy's action client does, without its losses, and in the lean way its costs.

    - A result may be asked for any number of times, whoever sent the goal.
    - Nothing is kept of a goal; one future a goal leaks in rclpy 7.1.6 and 9.1.2.
    - In the lean way answers are called back at once, where rclpy's futures make a turn of each;
      and status and feedback wake nobody, they are read when somebody asks.

    :ivar node: the node that it belongs to
    :ivar status: what the server says of its goals
    """

    def __init__(self, node: Node, action_class: Any, name: str, way: Way) -> None:
        """Make the parts; their names are remapped as any other."""
        check_for_type_support(action_class)
        wire = action_class.Impl
        self.node = node
        self.status = ServerStatus(node, name, way)
        self._goal_request = wire.SendGoalService.Request()
        self._result_request = wire.GetResultService.Request()
        """Filled anew for each goal: they are written out when they are sent."""
        within = f'{name}/_action'
        services = (
            Service(wire.SendGoalService, f'{within}/send_goal'),
            Service(wire.GetResultService, f'{within}/get_result', _knows_the_goal),
            Service(CancelGoal, f'{within}/cancel_goal'),
        )
        logger = node.get_logger().get_child('action_client')
        self._services, self._end = way.clients(node, logger, services)
        self._goals, self._results, self._cancels = self._services
        self._feedback = way.last_message(
            node, wire.FeedbackMessage, f'{within}/feedback', QoSProfile(depth=1)
        )
        self._asked: dict[bytes, list[Question]] = {}
        self._is_whole = False
        self._taking = node.resolve_service_name(f'{name}/_action/send_goal')
        self._telling = node.resolve_topic_name(f'{name}/_action/status')

    # --- the server -----------------------------------------------------------------------------

    def server_is_there(self) -> bool:
        """Tell whether a server is there; costs next to nothing as long as it stays.

        It has come when all its parts are in the ROS graph, and is gone without its status topic.
        """
        self._is_whole = self.status.is_published and (
            self._is_whole or all(service.is_served() for service in self._services)
        )
        return self._is_whole

    def count_servers(self, node: Node | None = None) -> int:
        """Count the servers, those too that publish no status. Goes through the whole ROS graph.

        :param node: another one that looks, in place of the client's own
        """
        takers = self.count_takers(node)
        publishers = (
            self.status.publishers if node is None else node.count_publishers(self._telling)
        )
        return max(takers, int(publishers))

    def count_takers(self, node: Node | None = None) -> int:
        """Count the servers that take goals.

        :param node: another one that looks, in place of the client's own
        """
        return self._goals.servers() if node is None else int(node.count_services(self._taking))

    def takers(self) -> Sequence[str]:
        """Return the full names of the nodes that take goals; asks for every node there is."""
        nodes = self.node.get_node_names_and_namespaces()
        return [f'{at.rstrip("/")}/{name}' for name, at in nodes if self._is_taken_by(name, at)]

    def _is_taken_by(self, name: str, namespace: str) -> bool:
        try:
            served = self.node.get_service_names_and_types_by_node(name, namespace)
        except RuntimeError:
            return False  # it has just left
        return any(service == self._taking for service, _ in served)

    # --- goals ----------------------------------------------------------------------------------

    def send(self, goal: Any, goal_id: UUID, answered: Answered) -> Question:
        """Send a goal.

        :param answered: called with the answer, which has `accepted`
        """
        self._goal_request.goal_id, self._goal_request.goal = goal_id, goal
        question = self._goals.ask(self._goal_request, answered)
        os.sched_yield()  # a server on this machine may wait for this processor
        return question

    def feedback(self, goal_id: UUID) -> Any:
        """Return the feedback of a goal of any client; None: the last message is not about it."""
        message = self._feedback.read()
        if message is None or bytes(message.goal_id.uuid) != bytes(goal_id.uuid):
            return None
        return message.feedback

    def ask_result(self, goal_id: UUID, answered: Answered) -> None:
        """Ask for the result of a goal of any client; an unknown goal is answered at once.

        :param answered: called with each answer, which has `status` and `result`: that a goal is
            unknown leaves the question open, for another server of the name may know it (but in
            the plain way)
        """
        self._result_request.goal_id = goal_id
        question = self._results.ask(self._result_request, answered)
        self._asked.setdefault(bytes(goal_id.uuid), []).append(question)

    def request_cancel(self, goal_id: UUID) -> None:
        """Ask to cancel a goal of any client; the answer does not matter, its end will tell."""
        self._cancels.tell(CancelGoal.Request(goal_info=GoalInfo(goal_id=goal_id)))

    def forget(self, goal_id: UUID) -> None:
        """Stop asking about a goal: a busy server may have dropped some of the questions."""
        for question in self._asked.pop(bytes(goal_id.uuid), ()):
            question.drop()

    def destroy(self) -> None:
        """Leave the ROS graph."""
        self._end()
        self._feedback.destroy()
        self.status.destroy()


def _knows_the_goal(response: Any) -> bool:
    return bool(response.status != GoalStatus.STATUS_UNKNOWN)
