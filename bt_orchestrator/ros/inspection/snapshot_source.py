"""The sources of snapshots: the tree, the blackboard, the statistics."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterable
from itertools import islice
from statistics import fmean, pvariance
from typing import Any, NamedTuple, TypeVar

from diagnostic_msgs.msg import KeyValue
from py_trees.blackboard import Blackboard
from py_trees_ros_interfaces.msg import ActivityItem, BehaviourTree, Statistics
from rclpy.node import Node
from rclpy.serialization import serialize_message

from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.ros.inspection.tree_messages import TreeMessages

_T = TypeVar('_T')

WINDOW = 100
"""Averages are over so many ticks: they show the present work of the cell."""


class Measured(NamedTuple):
    """Seconds."""

    last: float
    average: float
    variance: float


class TickStatistics:
    """Counts and times ticks. A tick here is a settle: all that one piece of news leads to."""

    def __init__(self, clock: Callable[[], float] = time.perf_counter) -> None:
        self.count = 0
        self._clock = clock
        self._started: float | None = None
        self._durations: deque[float] = deque(maxlen=WINDOW)
        self._intervals: deque[float] = deque(maxlen=WINDOW)

    def timed(self, settle: Callable[[], _T]) -> Callable[[], _T]:
        """Return the same call, measured."""

        def call() -> _T:
            started = self._clock()
            if self._started is not None:
                self._intervals.append(started - self._started)
            self._started = started
            self.count += 1
            try:
                return settle()
            finally:
                self._durations.append(self._clock() - started)

        return call

    @property
    def duration(self) -> Measured:
        """Time that ticks take."""
        return _measured(self._durations)

    @property
    def interval(self) -> Measured:
        """Time from the start of one tick to the start of the next."""
        return _measured(self._intervals)


def _measured(values: deque[float]) -> Measured:
    if not values:
        return Measured(0.0, 0.0, 0.0)
    # Rounding must not make it negative: watchers take the root.
    return Measured(values[-1], fmean(values), max(pvariance(values), 0.0))


class SnapshotSource:
    """Makes snapshots; the tree is looked at once for all streams, and only if it has changed."""

    def __init__(
        self, node: Node, orchestrator: Orchestrator, ticks: TickStatistics, activity: ActivityLog
    ) -> None:
        self.activity = activity
        self._node = node
        self._orchestrator = orchestrator
        self._ticks = ticks
        self._tree = TreeMessages()
        self._seen: object = None

    @property
    def moment(self) -> tuple[object, ...]:
        """Stand for the state of the tree: after its first tick, it changes with events only."""
        orchestrator = self._orchestrator
        return id(orchestrator.tree), orchestrator.state.seq, self._ticks.count > 0

    @property
    def version(self) -> int:
        """Another number whenever a status or the tree itself has changed."""
        return self._tree.version

    @property
    def visited_keys(self) -> set[str]:
        """Blackboard keys of the behaviours that the last tick went through."""
        return self._tree.visited_keys

    def refresh(self) -> None:
        """Look at the tree."""
        if self._seen != self.moment:
            self._tree.refresh(self._orchestrator.tree.root)
            self._seen = self.moment

    def serialized(self, *, changed: bool, data: bool, activity_since: int | None) -> bytes:
        """Return a snapshot as it goes over the wire."""
        message = BehaviourTree(
            behaviours=self._tree.messages, changed=changed, statistics=self._statistics()
        )
        if data:
            variables = blackboard_values(sorted(self.visited_keys))
            message.blackboard_on_visited_path = [
                KeyValue(key=key, value=value) for key, value in variables
            ]
        if activity_since is not None:
            done = self.activity.since(activity_since)
            message.blackboard_activity = [ActivityItem(**item._asdict()) for item in done]
        return bytes(serialize_message(message))

    def _statistics(self) -> Statistics:
        duration, interval = self._ticks.duration, self._ticks.interval
        return Statistics(
            count=self._ticks.count,
            stamp=self._node.get_clock().now().to_msg(),
            tick_duration=duration.last,
            tick_duration_average=duration.average,
            tick_duration_variance=duration.variance,
            tick_interval=interval.last,
            tick_interval_average=interval.average,
            tick_interval_variance=interval.variance,
        )


# Reading the blackboard, and what is done on it.

_KEPT = 500
"""How many activities are kept for a stream that has not shown them yet."""

UNSET = '-'


def blackboard_variables() -> list[str]:
    """Return every key that a client has registered."""
    return sorted(Blackboard.keys())


def blackboard_values(names: Iterable[str]) -> list[tuple[str, str]]:
    """Return variables with their values as text.

    :param names: keys, or KEY.FIELD; a key may lack its first slash
    """
    return [(name, _value(name)) for name in names]


def key_of(name: str) -> str:
    """Return the key that a variable or a field of it belongs to."""
    return str(Blackboard.absolute_name('/', name)).split('.')[0]


def _value(name: str) -> str:
    try:
        return str(Blackboard.get(name))
    except Exception:  # noqa: BLE001 - not set; or whatever a property or a str() of it raises
        return UNSET


class Activity(NamedTuple):
    """One thing that a client did; the values as text."""

    key: str
    client_name: str
    activity_type: str
    previous_value: str
    current_value: str


class ActivityLog:
    """The changes of the blackboard since some stream began to be interested.

    py_trees records it only meanwhile, as recording slows every access down.
    """

    def __init__(self) -> None:
        self.position = 0
        """Number of activities so far."""
        self._kept: list[Activity] = []
        self._recording = False

    def record(self, *, wanted: bool) -> None:
        """Begin or end to record."""
        if wanted and not self._recording:
            Blackboard.enable_activity_stream(maximum_size=_KEPT)
        elif self._recording and not wanted:
            Blackboard.disable_activity_stream()
            self._kept.clear()
        self._recording = wanted

    def collect(self) -> None:
        """Take in what was done since the last call."""
        stream = Blackboard.activity_stream
        if not self._recording or stream is None or not stream.data:
            return
        items, stream.data = stream.data, []
        self._kept += map(_activity, items)
        del self._kept[:-_KEPT]
        self.position += len(items)

    def since(self, position: int) -> list[Activity]:
        """Return the changes after a position, as far as they are kept."""
        missed = min(self.position - position, len(self._kept))
        return list(islice(self._kept, len(self._kept) - missed, None))


def _activity(item: Any) -> Activity:
    return Activity(
        str(item.key),
        str(item.client_name),
        str(item.activity_type),
        str(item.previous_value),
        str(item.current_value),
    )
