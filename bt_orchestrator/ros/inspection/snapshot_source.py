"""The sources of snapshots: the tree, the blackboard, the statistics."""

from __future__ import annotations

from diagnostic_msgs.msg import KeyValue
from py_trees_ros_interfaces.msg import ActivityItem, BehaviourTree, Statistics
from rclpy.node import Node
from rclpy.serialization import serialize_message

from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.ros.inspection import blackboard_view
from bt_orchestrator.ros.inspection.blackboard_view import ActivityLog
from bt_orchestrator.ros.inspection.tick_statistics import TickStatistics
from bt_orchestrator.ros.inspection.tree_messages import TreeMessages


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
            found = blackboard_view.values(sorted(self.visited_keys))
            message.blackboard_on_visited_path = [
                KeyValue(key=key, value=value) for key, value in found
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
