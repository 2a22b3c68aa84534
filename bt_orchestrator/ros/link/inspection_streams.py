"""Watching a tree node's inspection server: its tree and its blackboard, as they change."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from py_trees_ros_interfaces.msg import BehaviourTree, SnapshotStreamParameters
from py_trees_ros_interfaces.srv import OpenBlackboardStream, OpenSnapshotStream
from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_msgs.msg import String

from bt_orchestrator.model.branch import Branch, Outcome
from bt_orchestrator.ros.qos import LATCHED, create_client

ASK_AGAIN_S = 3.0
"""A service that a client sees may not see the client yet, and then its answer is lost."""

TEXT = QoSProfile(depth=10)


class _Kind(NamedTuple):
    """The request for a stream, and its content."""

    service: str
    service_class: Any
    request: Any
    topic_field: str
    message_class: Any
    qos: QoSProfile


class InspectionStream:
    """A stream of the inspection server, asked for again whenever it has gone.

    Nothing here waits: `look` is to be called a few times a second. Implements `ports.Watch`.
    """

    def __init__(self, node: Node, server: str, kind: _Kind, hear: Callable[[Any], None]) -> None:
        self._node = node
        self._kind = kind
        self._hear = hear
        self._client: Any = create_client(node, kind.service_class, f'{server}/{kind.service}')
        self._answer: Any = None
        self._asked_at = 0.0
        self._topic = ''
        self._subscription: Any = None
        self._was_there = False
        self.is_closed = False

    def close(self) -> None:
        """Stop listening: the server ends a stream without listeners."""
        self.is_closed = True
        self._forget()

    def look(self) -> None:
        """Go one step on: ask, listen, or notice that the stream has gone."""
        if self._topic:
            self._look_at_publisher()
        elif self._answer is not None and self._answer.done():
            self._listen(str(getattr(self._answer.result(), self._kind.topic_field)))
        elif self._may_ask():
            self._asked_at = time.monotonic()
            self._answer = self._client.call_async(self._kind.request)

    def _may_ask(self) -> bool:
        is_due = time.monotonic() - self._asked_at > ASK_AGAIN_S
        return is_due and bool(self._client.service_is_ready())

    def _listen(self, topic: str) -> None:
        """Listen to a topic; none is named where the server refused."""
        self._answer = None
        if topic:
            self._topic, self._was_there = topic, False
            self._subscription = self._node.create_subscription(
                self._kind.message_class, topic, self._heard, self._kind.qos
            )

    def _heard(self, message: Any) -> None:
        if not self.is_closed:
            self._hear(message)

    def _look_at_publisher(self) -> None:
        is_there = self._node.count_publishers(self._topic) > 0
        if self._was_there and not is_there:
            self._forget()
        self._was_there = is_there

    def _forget(self) -> None:
        if self._subscription is not None:
            self._node.destroy_subscription(self._subscription)
        self._subscription, self._topic = None, ''


def tree_stream(node: Node, server: str, hear: Callable[[Branch], None]) -> InspectionStream:
    """Return a stream that calls back with the tree, when it has changed."""

    def hear_tree(message: Any) -> None:
        tree = tree_of(message.behaviours)
        if tree is not None:
            hear(tree)

    on_change = SnapshotStreamParameters(snapshot_period=sys.float_info.max)
    kind = _Kind(
        'snapshot_streams/open',
        OpenSnapshotStream,
        OpenSnapshotStream.Request(parameters=on_change),
        'topic_name',
        BehaviourTree,
        LATCHED,
    )
    return InspectionStream(node, server, kind, hear_tree)


def blackboard_stream(
    node: Node, server: str, hear: Callable[[Mapping[str, str]], None]
) -> InspectionStream:
    """Return a stream that calls back with all variables, when one has changed."""
    kind = _Kind(
        'blackboard_streams/open',
        OpenBlackboardStream,
        OpenBlackboardStream.Request(),
        'topic',
        String,
        TEXT,
    )
    return InspectionStream(node, server, kind, lambda message: hear(variables(message.data)))


def variables(text: str) -> dict[str, str]:
    """Return the variables in a text of the blackboard, which has one a line below its title."""
    values: dict[str, str] = {}
    for line in text.splitlines()[1:]:
        key, colon, value = line.strip().partition(' : ')
        if colon:
            values[key.strip()] = value
    return values


# Snapshots of the inspection server as trees.

DECORATOR = 6
"""The type of a decorator in a snapshot (py_trees_ros_interfaces/msg/Behaviour.DECORATOR)."""


def tree_of(behaviours: Sequence[Any]) -> Branch | None:
    """Return the tree of a snapshot (py_trees_ros_interfaces/msg/Behaviour[])."""
    by_id = {bytes(behaviour.own_id.uuid): behaviour for behaviour in behaviours}
    parents = (bytes(behaviour.parent_id.uuid) for behaviour in behaviours)
    for behaviour, parent in zip(behaviours, parents, strict=True):
        if parent not in by_id:
            return _branch(behaviour, by_id)
    return None


def _branch(behaviour: Any, by_id: Mapping[bytes, Any]) -> Branch:
    children = (by_id[bytes(child.uuid)] for child in behaviour.child_ids)
    return Branch(
        name=behaviour.name,
        status=Outcome(behaviour.status),
        words=behaviour.message,
        is_decorator=behaviour.type == DECORATOR,
        children=tuple(_branch(child, by_id) for child in children),
    )
