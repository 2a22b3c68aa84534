"""Streams for tree watchers: their topics, who still watches, and why one is not opened."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import Protocol

from rclpy.exceptions import InvalidTopicNameException
from rclpy.node import Node
from rclpy.validate_full_topic_name import validate_full_topic_name

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.model.limits import STREAMS

FIRST_WAIT_S = 30.0
"""How long a stream waits for its first subscriber: discovery can be slow."""

GRACE_S = 5.0
"""How long a stream stays without subscribers, once it had one."""


DISCOVERY_S = 3.0
"""How long a watcher needs to find its stream: before that it is not ended for another one."""


class Attachment:
    """The subscribers of one stream over time.

    States: expected (nobody has come yet), attached, alone (all have left); over, once the second
    or the first has lasted too long. A watcher that was killed leaves when the middleware notices.
    """

    def __init__(self, now: float) -> None:
        """Expect a subscriber.

        :param now: seconds, of a clock that does not jump
        """
        self.count = 0
        self.is_permanent = False
        """Whether the stream stays without subscribers too."""
        self._until = now + FIRST_WAIT_S
        self._announced = now

    def look(self, count: int, now: float) -> bool:
        """Take note of the number of subscribers; tell whether there is a new one."""
        came = count > self.count
        if self.count and not count:
            self._until = now + GRACE_S
        self.count = count
        return came

    def expect(self, now: float) -> None:
        """Expect a further subscriber, as long as for the first one."""
        self._until = max(self._until, now + FIRST_WAIT_S)
        self._announced = now

    def may_give_way(self, now: float) -> bool:
        """Tell whether it may be ended because another stream is wanted: it has no watcher."""
        return not (self.count or self.is_permanent) and now >= self._announced + DISCOVERY_S

    def is_over(self, now: float) -> bool:
        """Tell whether there is no watcher, and none is expected any longer."""
        return not (self.count or self.is_permanent) and now >= self._until


class Stream(Protocol):
    """The part of a stream that is needed here."""

    attachment: Attachment


def to_end_for_another(streams: Mapping[str, Stream], kind: str, now: float) -> str | None:
    """Return the stream that has to end for another one to begin; None: there is room.

    It is the oldest one without a watcher. Services do not tell who asks, so whoever opens
    streams and does not watch them is the one who loses them.

    :param streams: by topic, the oldest first
    :raises StreamRefused: all are watched, or may be in a moment
    """
    asked_for = [name for name, stream in streams.items() if not stream.attachment.is_permanent]
    if len(asked_for) < STREAMS:
        return None
    for name in asked_for:
        if streams[name].attachment.may_give_way(now):
            return name
    raise StreamRefused(
        f'{STREAMS} {kind} streams are open, each with a watcher or just opened; close one'
    )


# Why a stream is not opened.


class StreamRefused(OrchestratorError):
    """A stream cannot be opened as requested."""


# The topics of streams.


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
