"""What an action server says of its goals."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from action_msgs.msg import GoalStatus, GoalStatusArray
from rclpy.node import Node
from rclpy.qos import qos_profile_action_status_default
from unique_identifier_msgs.msg import UUID

from bt_orchestrator.ros.last_message import LastMessage

_ACTIVE = (GoalStatus.STATUS_ACCEPTED, GoalStatus.STATUS_EXECUTING, GoalStatus.STATUS_CANCELING)


class ServerStatus:
    """The last message of its status topic, which is latched and lists all that it remembers.

    A server publishes it three times a goal, the last time just before the result: it is read
    when somebody asks.
    """

    def __init__(self, node: Node, action: str) -> None:
        self._node = node
        self._name = f'{action}/_action/status'
        self._topic = LastMessage(
            node, GoalStatusArray, self._name, qos_profile_action_status_default
        )
        self._read: Any = None
        self._listed: Mapping[bytes, int] = {}

    @property
    def is_published(self) -> bool:
        """Tell whether a publisher is connected; costs next to nothing."""
        return self._topic.publishers > 0

    def publisher_id(self) -> str | None:
        """Return an id of the publisher, which no other instance of the server has.

        None: there is no server, or more than one. Takes a tenth of a millisecond.
        """
        publishers = self._node.get_publishers_info_by_topic(self._name)
        return bytes(publishers[0].endpoint_gid).hex() if len(publishers) == 1 else None

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
            self._listed = {
                bytes(one.goal_info.goal_id.uuid): one.status for one in message.status_list
            }
        return self._listed
