"""A tree watcher of our own, which speaks the watchers' wire contract, for tests.

Run as a program, it watches the tree of a node until it is killed.
"""

from __future__ import annotations

import signal
import subprocess
import sys
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any
from uuid import UUID

from action_caller import ActionCaller
from py_trees_ros_interfaces import srv
from py_trees_ros_interfaces.msg import Behaviour, BehaviourTree, SnapshotStreamParameters
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String

ON_CHANGE_S = sys.float_info.max

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
VOLATILE = QoSProfile(depth=100)

ASK_AGAIN_S = 10.0

READY = 'watching: '

_ZERO = UUID(int=0)
_TYPES = {
    Behaviour.BEHAVIOUR,
    Behaviour.SEQUENCE,
    Behaviour.SELECTOR,
    Behaviour.PARALLEL,
    Behaviour.DECORATOR,
}


def parameters(
    period_s: float = ON_CHANGE_S, *, data: bool = False, activity: bool = False
) -> Any:
    return SnapshotStreamParameters(
        snapshot_period=period_s, blackboard_data=data, blackboard_activity=activity
    )


class WatchingClient:
    """Everything runs in its caller's thread, in the waiting calls."""

    def __init__(self, node: str = '/bt_orchestrator') -> None:
        self.node = node
        self.ros = ActionCaller()
        self._clients: dict[str, Any] = {}

    def close(self) -> None:
        """Leave ROS."""
        self.ros.close()

    # --- asking -------------------------------------------------------------------------------

    def open(self, wanted: Any = None, topic: str = '') -> str:
        """Open a snapshot stream; the answer is its topic, or nothing if it is refused."""
        request = srv.OpenSnapshotStream.Request(
            topic_name=topic, parameters=wanted or parameters()
        )
        return str(self._call(srv.OpenSnapshotStream, 'snapshot_streams/open', request).topic_name)

    def close_stream(self, topic: str) -> bool:
        """Close a snapshot stream."""
        request = srv.CloseSnapshotStream.Request(topic_name=topic)
        return bool(self._call(srv.CloseSnapshotStream, 'snapshot_streams/close', request).result)

    def reconfigure(self, topic: str, wanted: Any) -> bool:
        """Change the parameters of a snapshot stream."""
        request = srv.ReconfigureSnapshotStream.Request(topic_name=topic, parameters=wanted)
        name = 'snapshot_streams/reconfigure'
        return bool(self._call(srv.ReconfigureSnapshotStream, name, request).result)

    def variables(self) -> list[str]:
        """List the blackboard."""
        request = srv.GetBlackboardVariables.Request()
        name = 'blackboard_streams/get_variables'
        return list(self._call(srv.GetBlackboardVariables, name, request).variables)

    def open_text(self, *variables: str, visited: bool = False, activity: bool = False) -> str:
        """Open a stream of the blackboard as text and return its topic."""
        request = srv.OpenBlackboardStream.Request(
            variables=variables, filter_on_visited_path=visited, with_activity_stream=activity
        )
        return str(self._call(srv.OpenBlackboardStream, 'blackboard_streams/open', request).topic)

    def close_text(self, topic: str) -> bool:
        """Close a stream of the blackboard."""
        request = srv.CloseBlackboardStream.Request(topic_name=topic)
        name = 'blackboard_streams/close'
        return bool(self._call(srv.CloseBlackboardStream, name, request).result)

    def _call(self, kind: Any, service: str, request: Any) -> Any:
        if service not in self._clients:
            name = f'{self.node}/{service}'
            self._clients[service] = self.ros.node.create_client(kind, name)
        client = self._clients[service]
        self.ros.spin_until(client.service_is_ready, f'the service {service}')
        answer = client.call_async(request)
        # A service that a client sees ready may not yet see the client, and its answer is lost.
        if not self.ros.spin_for(ASK_AGAIN_S, answer.done):
            answer = client.call_async(request)
        return self.ros.wait(answer, f'an answer of {service}')

    # --- watching -----------------------------------------------------------------------------

    def watch(self, topic: str) -> list[Snapshot]:
        """Subscribe to snapshots; the list grows while callbacks run."""
        seen: list[Snapshot] = []

        def on_message(message: Any) -> None:
            seen.append(Snapshot(message))

        self.ros.node.create_subscription(BehaviourTree, topic, on_message, LATCHED)
        return seen

    def watch_text(self, topic: str) -> list[str]:
        """Subscribe to text; the list grows while callbacks run."""
        seen: list[str] = []

        def on_message(message: Any) -> None:
            seen.append(message.data)

        self.ros.node.create_subscription(String, topic, on_message, VOLATILE)
        return seen

    def until(self, seen: list[Snapshot], is_so: Callable[[Snapshot], Any], what: str) -> Snapshot:
        """Wait for a snapshot of which something is so, and return it."""
        self.ros.spin_until(lambda: any(map(is_so, seen)), f'a snapshot: {what}')
        return next(filter(is_so, seen))

    def until_gone(self, topic: str, within_s: float) -> None:
        """Wait until nobody publishes on a topic."""
        gone = self.ros.spin_for(within_s, lambda: not self.ros.node.count_publishers(topic))
        assert gone, f'{topic} is still there after {within_s:g} s'


class Snapshot:
    """A snapshot, which must be one that the watchers out there can show."""

    def __init__(self, message: Any) -> None:
        self.message = message
        self.by_name = {behaviour.name: behaviour for behaviour in message.behaviours}
        _check_tree(message.behaviours)
        for behaviour in message.behaviours:
            _check_values(behaviour)
        statistics = message.statistics
        assert min(statistics.tick_duration_variance, statistics.tick_interval_variance) >= 0

    def status(self, name: str) -> int | None:
        """Return the status of a behaviour; None: it is not in the tree."""
        behaviour = self.by_name.get(name)
        return None if behaviour is None else int(behaviour.status)

    def text(self, name: str) -> str:
        """Return the words of a behaviour."""
        return str(self.by_name[name].message)


def _check_tree(behaviours: list[Any]) -> None:
    ids = [_uuid(behaviour.own_id) for behaviour in behaviours]
    assert all(each.version == 4 for each in ids)
    assert len(set(ids)) == len(ids)
    parents = {_uuid(b.own_id): _uuid(b.parent_id) for b in behaviours}
    assert Counter(parents.values())[_ZERO] == 1, 'exactly one root'
    for behaviour in behaviours:
        children = [_uuid(child) for child in behaviour.child_ids]
        assert all(parents[child] == _uuid(behaviour.own_id) for child in children)
        assert {_uuid(behaviour.current_child_id), _ZERO} <= {*children, _ZERO}
        assert _uuid(behaviour.tip_id) in {*ids, _ZERO}
    assert sum(len(behaviour.child_ids) for behaviour in behaviours) == len(behaviours) - 1


def _check_values(behaviour: Any) -> None:
    assert behaviour.type in _TYPES
    assert behaviour.status in range(Behaviour.INVALID, Behaviour.FAILURE + 1)
    assert behaviour.blackbox_level in range(1, 5)
    assert behaviour.is_active == (behaviour.status != Behaviour.INVALID)
    assert {pair.value for pair in behaviour.blackboard_access} <= {'r', 'w', 'x'}
    if behaviour.type == Behaviour.DECORATOR:
        assert len(behaviour.child_ids) == 1


def _uuid(message: Any) -> UUID:
    return UUID(bytes=bytes(message.uuid))


class WatcherProcess:
    """A watching client in a process of its own, to be killed."""

    def __init__(self) -> None:
        self._process = subprocess.Popen(
            [sys.executable, '-u', __file__], stdout=subprocess.PIPE, text=True
        )

    def topic(self) -> str:
        """Wait for its first snapshot and return the topic that it watches."""
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        assert line.startswith(READY), line
        return line.removeprefix(READY).rstrip()

    def kill(self) -> None:
        """End it without a word to anybody; harmless if it has ended."""
        self._process.kill()
        self._process.wait()
        assert self._process.stdout is not None
        self._process.stdout.close()


def main() -> None:
    """Watch until killed, or for longer than any test takes."""
    signal.alarm(600)
    client = WatchingClient()
    topic = client.open()
    seen = client.watch(topic)
    client.ros.spin_until(lambda: seen, 'the first snapshot')
    print(f'{READY}{topic}')  # noqa: T201 - for the parent process
    client.ros.spin_for(600)


if __name__ == '__main__':
    sys.path.insert(0, str(Path(__file__).parent))
    main()
