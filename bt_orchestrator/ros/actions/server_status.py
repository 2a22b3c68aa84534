"""The goals in the status of an action server."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from action_msgs.msg import GoalStatus, GoalStatusArray
from rclpy.node import Node
from rclpy.qos import QoSProfile, qos_profile_action_status_default
from rclpy.topic_endpoint_info import TopicEndpointInfo
from unique_identifier_msgs.msg import UUID

from bt_orchestrator.ros.executor.handles import publisher_ids, subscription

_ACTIVE = (GoalStatus.STATUS_ACCEPTED, GoalStatus.STATUS_EXECUTING, GoalStatus.STATUS_CANCELING)


class ServerStatus:
    """The last message of its status topic, which is latched and lists all that it remembers.

    A server publishes it three times a goal, the last time just before the result: it is read
    when somebody asks.
    """

    def __init__(self, node: Node, action: str) -> None:
        self._node = node
        self._name = f'{action}/_action/status'
        self._full_name = node.resolve_topic_name(self._name)
        self._topic = LastMessage(
            node, GoalStatusArray, self._name, qos_profile_action_status_default
        )
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

    def publisher_id(self) -> str | None:
        """Return an id of the publisher, which no other instance of the server has.

        None: there is no server, or more than one. Goes through the whole ROS graph.
        """
        ids = publisher_ids(self._node, self._full_name)
        return ids[0] if len(ids) == 1 else None

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
            infos = [(bytes(one.goal_info.goal_id.uuid), one) for one in message.status_list]
            self._listed = {goal: one.status for goal, one in infos}
            self._stamps = {goal: one.goal_info.stamp for goal, one in infos}
        return self._listed


# A topic whose last message only is read, and only on demand.


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
