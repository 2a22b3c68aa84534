"""Streams of the blackboard as text, one topic a watcher."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_msgs.msg import String

from bt_orchestrator.ros.inspection import snapshot_source
from bt_orchestrator.ros.inspection.snapshot_source import SnapshotSource
from bt_orchestrator.ros.inspection.streams import Attachment, TopicNames, to_end_for_another

TEXT = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)


class View(NamedTuple):
    """The wishes of a watcher."""

    variables: tuple[str, ...]
    """None: all."""
    only_visited: bool
    with_activity: bool


class _Stream:
    def __init__(self, publisher: Any, view: View, now: float, activity: int) -> None:
        self.publisher = publisher
        self.view = view
        self.attachment = Attachment(now)
        self.activity = activity
        self.values: list[tuple[str, str]] | None = None
        """The last published content; None: nothing that the present watcher could have got."""


class BlackboardStreams:
    """All streams of the blackboard of a node. A stream says something when a value changes."""

    def __init__(self, node: Node, source: SnapshotSource) -> None:
        self._node = node
        self._source = source
        self._names = TopicNames(node, 'blackboard_streams', '_watcher_', 'std_msgs/msg/String')
        self._streams: dict[str, _Stream] = {}

    def __len__(self) -> int:
        return len(self._streams)

    @property
    def wants_activity(self) -> bool:
        """Tell whether any stream shows what is done on the blackboard."""
        return any(stream.view.with_activity for stream in self._streams.values())

    def open(self, view: View, now: float) -> str:
        """Open a stream and return its topic.

        :raises StreamRefused: too many streams
        """
        self.look(now)
        gives_way = to_end_for_another(self._streams, 'blackboard', now)
        if gives_way is not None:
            self.close(gives_way)
        name = self._names.new()
        publisher = self._node.create_publisher(String, name, TEXT)
        position = self._source.activity.position
        self._streams[name] = _Stream(publisher, view, now, position)
        return name

    def close(self, requested: str) -> bool:
        """Close a stream; tell whether there was one."""
        stream = self._streams.pop(self._names.full(requested), None)
        if stream is None:
            return False
        self._node.destroy_publisher(stream.publisher)
        return True

    def look(self, now: float) -> None:
        """Take note of watchers that came and went; end the streams without watchers."""
        for name, stream in list(self._streams.items()):
            if stream.attachment.look(stream.publisher.get_subscription_count(), now):
                # Watchers hear only what is said while they are there.
                stream.values = None
            if stream.attachment.is_over(now):
                self.close(name)

    def publish_due(self) -> None:
        """Publish on every stream whose watcher has something new to see."""
        watched = [stream for stream in self._streams.values() if stream.attachment.count]
        if any(stream.view.only_visited for stream in watched):
            self._source.refresh()
        for stream in watched:
            self._publish(stream)

    def _publish(self, stream: _Stream) -> None:
        log, view = self._source.activity, stream.view
        values = self._values(view)
        done = log.since(stream.activity) if view.with_activity else []
        stream.activity = log.position
        if values == stream.values and not done:
            return
        stream.values = values
        text = _text('Blackboard Data', values)
        if view.with_activity:
            text += _text('Blackboard Activity', [_line(item) for item in done])
        stream.publisher.publish(String(data=text))

    def _values(self, view: View) -> list[tuple[str, str]]:
        names: Sequence[str] = view.variables or snapshot_source.blackboard_variables()
        if view.only_visited:
            visited = self._source.visited_keys
            names = [name for name in names if snapshot_source.key_of(name) in visited]
        return snapshot_source.blackboard_values(names)


def _line(item: snapshot_source.Activity) -> tuple[str, str]:
    values = [value for value in (item.previous_value, item.current_value) if value != 'None']
    return item.key, f'{item.activity_type:<12} {item.client_name}  {" -> ".join(values)}'.rstrip()


def _text(title: str, pairs: Sequence[tuple[str, str]]) -> str:
    width = max((len(key) for key, _ in pairs), default=1)
    lines = [f'    {key:<{width}} : {value}' for key, value in pairs or [('-', '-')]]
    return '\n'.join([title, *lines, ''])
