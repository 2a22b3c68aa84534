"""Streams of snapshots of the tree, one topic a watcher."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from py_trees_ros_interfaces.msg import BehaviourTree
from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.node import Node

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.ros.inspection.snapshot_source import SnapshotSource
from bt_orchestrator.ros.inspection.streams import (
    Attachment,
    StreamRefused,
    TopicNames,
    to_end_for_another,
)
from bt_orchestrator.ros.qos import LATCHED

ON_CHANGE_S = sys.float_info.max
"""The period that stands for: only when something has changed."""


@dataclass(frozen=True)
class DefaultStream:
    """The snapshot stream that is there without being asked for."""

    is_open: bool = False
    period_s: float = ON_CHANGE_S
    blackboard_data: bool = True
    blackboard_activity: bool = False


_FIELDS = {
    'default_snapshot_stream': ('is_open', 'Publish snapshots of the tree on ~/snapshots.'),
    'default_snapshot_period': (
        'period_s',
        f'Longest time between snapshots of the default stream, s; {ON_CHANGE_S}: on change only.',
    ),
    'default_snapshot_blackboard_data': (
        'blackboard_data',
        'The default stream shows the blackboard variables of the visited path.',
    ),
    'default_snapshot_blackboard_activity': (
        'blackboard_activity',
        'The default stream shows what is done on the blackboard.',
    ),
}


def declare_default_stream(node: Node, apply: Callable[[DefaultStream], object]) -> None:
    """Declare the parameters of the default stream and apply them, now and when they change."""
    current = DefaultStream()
    for name, (field, text) in _FIELDS.items():
        default = getattr(current, field)
        value = node.declare_parameter(name, default, ParameterDescriptor(description=text)).value
        current = replace(current, **{field: value})
    apply(current)

    def on_set(parameters: Iterable[Any]) -> SetParametersResult:
        nonlocal current
        news = {_FIELDS[p.name][0]: p.value for p in parameters if p.name in _FIELDS}
        if not news:
            return SetParametersResult(successful=True)
        try:
            wanted = replace(current, **news)
            apply(wanted)
        except OrchestratorError as refused:
            return SetParametersResult(successful=False, reason=str(refused))
        current = wanted
        return SetParametersResult(successful=True)

    node.add_on_set_parameters_callback(on_set)


DEFAULT_TOPIC = '~/snapshots'


class StreamParameters(NamedTuple):
    """The content of a stream, and its rate when nothing changes."""

    period_s: float
    blackboard_data: bool
    blackboard_activity: bool


class SnapshotStream:
    """One topic and what was last published there."""

    def __init__(self, publisher: Any, parameters: StreamParameters, now: float) -> None:
        self.publisher = publisher
        self.parameters = parameters
        self.attachment = Attachment(now)
        self.openers = 1
        """How many watchers share it: those that asked for the same topic by name."""
        self.published_at = -math.inf
        self.moment: Any = None
        self.version = -1
        self.activity = 0

    def is_due(self, moment: object, now: float) -> bool:
        """Tell whether there is somebody to publish for, and something to publish."""
        if not self.attachment.count:
            return False
        return moment != self.moment or now - self.published_at >= self.parameters.period_s


class SnapshotStreams:
    """All streams of snapshots of a node; watchers that see the same share the work."""

    def __init__(self, node: Node, source: SnapshotSource) -> None:
        self._node = node
        self._source = source
        self._names = TopicNames(
            node, 'snapshot_streams', '_snapshots_', 'py_trees_ros_interfaces/msg/BehaviourTree'
        )
        self._streams: dict[str, SnapshotStream] = {}
        self._default = self._names.full(DEFAULT_TOPIC)

    def __len__(self) -> int:
        return len(self._streams)

    @property
    def wants_activity(self) -> bool:
        """Tell whether any stream shows what is done on the blackboard."""
        return any(stream.parameters.blackboard_activity for stream in self._streams.values())

    def open(self, requested: str, parameters: StreamParameters, now: float) -> str:
        """Open a stream and return its topic.

        :param requested: the topic; empty: any
        :raises StreamRefused: a bad name, bad parameters, or too many streams
        """
        _check(parameters)
        name = self._names.resolve(requested) if requested else self._names.new()
        if name in self._streams:
            self._share(name, parameters, now)
            return name
        self.look(now)
        self._destroy(to_end_for_another(self._streams, 'snapshot', now))
        self._create(name, parameters, now)
        return name

    def close(self, requested: str) -> bool:
        """Let a watcher go; tell whether there was such a stream."""
        name = self._find(requested)
        if name is None or name == self._default:
            return False
        stream = self._streams[name]
        stream.openers -= 1
        if not stream.openers:
            self._destroy(name)
        return True

    def reconfigure(self, requested: str, parameters: StreamParameters) -> bool:
        """Change what a stream shows; tell whether there is such a stream.

        :raises StreamRefused: bad parameters
        """
        _check(parameters)
        name = self._find(requested)
        if name is None:
            return False
        stream = self._streams[name]
        stream.parameters, stream.moment = parameters, None
        return True

    def configure_default(self, wanted: DefaultStream, now: float) -> None:
        """Open, change or close the stream that needs no asking.

        :raises StreamRefused: bad parameters
        """
        parameters = StreamParameters(
            wanted.period_s, wanted.blackboard_data, wanted.blackboard_activity
        )
        _check(parameters)
        if not wanted.is_open:
            self._destroy(self._default)
            return
        if not self.reconfigure(self._default, parameters):
            self._create(self._default, parameters, now)
        self._streams[self._default].attachment.is_permanent = True

    def publish_due(self, now: float) -> None:
        """Publish on every stream that is due."""
        moment = self._source.moment
        due = [stream for stream in self._streams.values() if stream.is_due(moment, now)]
        if not due:
            return
        self._source.refresh()
        made: dict[tuple[object, ...], bytes] = {}
        for stream in due:
            self._publish(stream, made)
            stream.moment, stream.published_at = moment, now

    def look(self, now: float) -> None:
        """Take note of watchers that came and went; end the streams without watchers."""
        for name, stream in list(self._streams.items()):
            stream.attachment.look(stream.publisher.get_subscription_count(), now)
            if stream.attachment.is_over(now):
                self._destroy(name)

    def _publish(self, stream: SnapshotStream, made: dict[tuple[object, ...], bytes]) -> None:
        wanted, source = stream.parameters, self._source
        since = stream.activity if wanted.blackboard_activity else None
        changed = stream.version != source.version
        key = (wanted.blackboard_data, since, changed)
        if key not in made:
            made[key] = source.serialized(
                changed=changed, data=wanted.blackboard_data, activity_since=since
            )
        stream.publisher.publish(made[key])
        stream.version, stream.activity = source.version, source.activity.position

    def _create(self, name: str, parameters: StreamParameters, now: float) -> None:
        publisher = self._node.create_publisher(BehaviourTree, name, LATCHED)
        stream = SnapshotStream(publisher, parameters, now)
        stream.activity = self._source.activity.position
        self._streams[name] = stream

    def _share(self, name: str, parameters: StreamParameters, now: float) -> None:
        stream = self._streams[name]
        if parameters != stream.parameters:
            if stream.attachment.count:
                raise StreamRefused(f'{name} is watched with other parameters')
            stream.parameters, stream.moment = parameters, None
        stream.openers += 1
        stream.attachment.expect(now)

    def _find(self, requested: str) -> str | None:
        """Return the name of a stream, which was given as the answer to open or as its request."""
        if requested in self._streams:
            return requested
        name = self._names.full(requested)
        return name if name in self._streams else None

    def _destroy(self, name: str | None) -> None:
        stream = self._streams.pop(name, None) if name is not None else None
        if stream is not None:
            self._node.destroy_publisher(stream.publisher)


def _check(parameters: StreamParameters) -> None:
    if not parameters.period_s >= 0:  # NaN is not, either
        period_s = parameters.period_s
        raise StreamRefused(f'snapshot_period: expected seconds, 0 or more; found {period_s}')
