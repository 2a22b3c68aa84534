"""The topics of streams."""

from __future__ import annotations

import itertools

from rclpy.exceptions import InvalidTopicNameException
from rclpy.node import Node
from rclpy.validate_full_topic_name import validate_full_topic_name

from bt_orchestrator.ros.inspection.stream_refused import StreamRefused


class TopicNames:
    """Finds the topic for each new stream of one kind."""

    def __init__(self, node: Node, folder: str, prefix: str, type_name: str) -> None:
        """Take the kind of streams.

        :param folder: below the node's name, where relative names are
        :param prefix: of names that nobody has asked for; hidden if it begins with _
        :param type_name: of the messages, as in pkg/msg/Name
        """
        self._node = node
        self._base = node.get_fully_qualified_name()
        self._folder = f'{self._base}/{folder}'
        self._prefix = prefix
        self._type_name = type_name
        self._numbers = itertools.count()

    def new(self) -> str:
        """Return a name that no stream of this node ever had."""
        return f'{self._folder}/{self._prefix}{next(self._numbers)}'

    def resolve(self, requested: str) -> str:
        """Return the full name for a name that was asked for.

        :raises StreamRefused: ROS 2 does not allow it, or something else is published there
        """
        name = self.full(requested)
        try:
            validate_full_topic_name(name)
        except InvalidTopicNameException as error:
            reason = ' '.join(str(error).split())
            raise StreamRefused(f'topic {requested!r} is not a valid name: {reason}') from error
        others = dict(self._node.get_topic_names_and_types()).get(name, [])
        if any(other != self._type_name for other in others):
            raise StreamRefused(f'topic {name} is taken, for {", ".join(others)}')
        return name

    def full(self, requested: str) -> str:
        """Return the full name for any text, valid or not."""
        if requested.startswith('/'):
            return requested
        if requested.startswith('~/'):
            return f'{self._base}/{requested[2:]}'
        return f'{self._folder}/{requested}'
