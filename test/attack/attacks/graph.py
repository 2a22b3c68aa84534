"""Attacks by what ROS 2 lets every participant do: parameters, streams, topics, subscriptions."""

from __future__ import annotations

import math
import random
import sys
from collections.abc import Iterator
from typing import Any

from attack import garbage
from attack.attacks.attack import Attack, Bounds
from attack.line import STATE_TOPIC
from attack.peer import Peer
from bt_orchestrator_interfaces.msg import Event, Status
from py_trees_ros_interfaces.msg import SnapshotStreamParameters
from py_trees_ros_interfaces.srv import OpenBlackboardStream, OpenSnapshotStream
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import ListParameters, SetParameters, SetParametersAtomically
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String

from bt_orchestrator.model.limits import STREAMS
from bt_orchestrator.ros.qos import EVENTS, LATCHED

_TYPES = {
    'bool_value': ParameterType.PARAMETER_BOOL,
    'integer_value': ParameterType.PARAMETER_INTEGER,
    'double_value': ParameterType.PARAMETER_DOUBLE,
    'string_value': ParameterType.PARAMETER_STRING,
    'byte_array_value': ParameterType.PARAMETER_BYTE_ARRAY,
    'string_array_value': ParameterType.PARAMETER_STRING_ARRAY,
}


class Parameters(Attack):
    """Every parameter set to something else by a peer, and a /clock that jumps."""

    name = 'parameters'

    def run(self, peer: Peer) -> None:
        """Set all, and publish times."""
        clock = peer.ros.node.create_publisher(Clock, '/clock', 10)
        names = self._names(peer)
        while peer.goes_on():
            requests = [self._parameter(peer.drawn, name) for name in names]
            peer.ask(SetParameters, 'set_parameters', SetParameters.Request(parameters=requests))
            kind = SetParametersAtomically
            peer.ask(kind, 'set_parameters_atomically', kind.Request(parameters=requests[:3]))
            for _ in range(50):
                time = Clock()
                time.clock.sec = peer.drawn.choice((0, 1, 2**31 - 1, peer.drawn.randrange(2**31)))
                clock.publish(time)
                peer.wait(0.01)
            peer.count('rounds')
        self._set_back(peer)

    def _names(self, peer: Peer) -> list[str]:
        answer = peer.ask(ListParameters, 'list_parameters', ListParameters.Request())
        names = list(answer.result.names) if answer else []
        if 'use_sim_time' not in names:
            names.append('use_sim_time')
        peer.count('parameters', len(names))
        return sorted(names)

    def _parameter(self, drawn: random.Random, name: str) -> Parameter:
        if name == 'use_sim_time':
            true = ParameterValue(type=ParameterType.PARAMETER_BOOL, bool_value=True)
            return Parameter(name=name, value=true)
        value = garbage.message(drawn, ParameterValue)
        value.type = drawn.choice(list(_TYPES.values()))
        return Parameter(name=name, value=value)

    def _set_back(self, peer: Peer) -> None:
        """Close the stream that may be opened by a parameter, which is its good right."""
        off = ParameterValue(type=ParameterType.PARAMETER_BOOL, bool_value=False)
        both = ('use_sim_time', 'default_snapshot_stream')
        request = SetParameters.Request(parameters=[Parameter(name=n, value=off) for n in both])
        peer.ask(SetParameters, 'set_parameters', request)


class Streams(Attack):
    """Inspection streams by the hundred, with names and periods that hurt, never closed."""

    name = 'streams'

    _MOST_OPEN = 2 * STREAMS
    """Of the tree, and of the blackboard."""
    _PERIODS = (math.nan, math.inf, -1.0, 0.0, 5e-324, 1e-9, 0.001, 1.0, sys.float_info.max)

    def run(self, peer: Peer) -> None:
        """Open them."""
        for number, _ in enumerate(iter(peer.goes_on, False)):
            if number >= 300:
                break
            name = self._name(peer.drawn, number)
            snapshots = OpenSnapshotStream.Request(topic_name=name, parameters=self._wanted(peer))
            peer.ask(OpenSnapshotStream, 'snapshot_streams/open', snapshots)
            texts = OpenBlackboardStream.Request(
                variables=[garbage.text(peer.drawn) for _ in range(number % 4)],
                filter_on_visited_path=bool(number % 2),
                with_activity_stream=bool(number % 3),
            )
            peer.ask(OpenBlackboardStream, 'blackboard_streams/open', texts)
        self._count(peer)

    def _wanted(self, peer: Peer) -> SnapshotStreamParameters:
        return SnapshotStreamParameters(
            snapshot_period=peer.drawn.choice(self._PERIODS),
            blackboard_data=peer.drawn.random() < 0.5,
            blackboard_activity=peer.drawn.random() < 0.5,
        )

    def _name(self, drawn: random.Random, number: int) -> str:
        hurting = garbage.text(drawn)
        return drawn.choice(('', hurting, f's{number}', f'/evil/s{number}', 'x' * 200, '~/status'))

    def _count(self, peer: Peer) -> None:
        """Complain of streams that one peer got beyond its share."""
        node = peer.target.node.rpartition('/')[2]
        published = peer.ros.node.get_publisher_names_and_types_by_node(node, '/')
        kinds = ('py_trees_ros_interfaces/msg/BehaviourTree', 'std_msgs/msg/String')
        streams = [name for name, types in published if set(types) & set(kinds)]
        peer.count('open', len(streams))
        if len(streams) > self._MOST_OPEN:
            peer.complain(f'one peer holds {len(streams)} inspection streams')


class States(Attack):
    """Garbage on state topics, a thousand messages a second."""

    name = 'states'
    bounds = Bounds(journal_mb=6.0)

    _A_TURN = 20
    _TURN_S = 0.02

    def run(self, peer: Peer) -> None:
        """Publish texts of any kind, raw bytes, and what is longer than any state."""
        states = peer.ros.node.create_publisher(String, STATE_TOPIC, 10)
        peer.wait(5.0, lambda: states.get_subscription_count() > 0)
        for message in self._messages(peer.drawn):
            states.publish(message)
            peer.count('messages')
            if not peer.report.counts['messages'] % self._A_TURN:
                peer.wait(self._TURN_S)
            if not peer.goes_on():
                break

    def _messages(self, drawn: random.Random) -> Iterator[Any]:
        while True:
            kind = drawn.random()
            if kind < 0.01:
                yield String(data='x' * garbage.LONG)
            elif kind < 0.1:
                yield b'\x00\x01\x00\x00' + drawn.randbytes(drawn.randint(0, 40))
            elif kind < 0.3:
                yield String(data='READY')
            else:
                yield String(data=garbage.text(drawn))


class Subscribers(Attack):
    """Subscribers of status and events that come and go."""

    name = 'subscribers'
    in_short = False  # verbs do it in every test

    _AT_ONCE = 10

    def run(self, peer: Peer) -> None:
        """Make some, hear something or not, and leave."""
        node = peer.ros.node
        while peer.goes_on():
            made = []
            for _ in range(self._AT_ONCE):
                kind, topic, profile = peer.drawn.choice(
                    ((Status, 'status', LATCHED), (Event, 'events', EVENTS))
                )
                name = f'{peer.target.node}/{topic}'
                made.append(node.create_subscription(kind, name, lambda _: None, profile))
            peer.wait(peer.drawn.uniform(0.0, 0.2))
            for subscription in made:
                node.destroy_subscription(subscription)
            peer.count('subscribers', self._AT_ONCE)
