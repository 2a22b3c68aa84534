"""The processes that run a cell under the name of a node: each publishes its identity.

A service client hears the first answer only, and the ROS graph lists a process that was killed for
20 s more. A latched message comes from its process, so whoever is heard is alive (decision 0023).
"""

from __future__ import annotations

import os
import socket
import time
import uuid
from collections.abc import Callable, Sequence
from datetime import datetime

from bt_orchestrator_interfaces.msg import Identity
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.limits import PLACE, cut
from bt_orchestrator.model.words import sentence
from bt_orchestrator.ros.clock import to_time
from bt_orchestrator.ros.qos import LATCHED, publisher, subscribe

TOPIC = 'identity'

LOOK_S = 1.0
"""Longest time to look for others; where the network is slow, they are found later."""

_STEP_S = 0.02

_MOST_KNOWN = 100
"""Of more nodes of one name no note is taken: the cell holds already."""

_FROM_ALL = QoSProfile(
    depth=20,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)


class TwinFound(OrchestratorError):
    """Another process runs a cell under the name that this one is to have."""


class Presence:
    """Makes a process known under the name of its node, and notices others of that name."""

    def __init__(self, node: Node) -> None:
        """Begin to listen."""
        self._node = node
        self._listener = Listener(node, f'~/{TOPIC}')
        self.own = Identity(
            instance=uuid.uuid4().hex,
            host=socket.gethostname(),
            pid=os.getpid(),
            started=to_time(time.time()),
        )

    def refuse_a_twin(self) -> None:
        """Look whether the name is free.

        :raises TwinFound: it is not; says where the other one is
        """
        others = self._listener.listen(bool, LOOK_S)
        if others:
            name = self._node.get_fully_qualified_name()
            raise TwinFound(
                f'{name} runs already: {where(others[0])}; stop that one, or give this '
                'one another name with --namespace'
            )

    def announce(
        self, cell: Cell, history: str, epoch: int, report: Callable[[str], object]
    ) -> None:
        """Say from now on who is here, and call back with words for each other one that is.

        :param epoch: which writer of its journal it is; 0: it has no other one
        """
        self._listener.close()
        name = self._node.get_fully_qualified_name()
        known = {self.own.instance}

        def heard(other: Identity) -> None:
            is_new = other.instance not in known and len(known) < _MOST_KNOWN
            # Of two writers of one journal the journal itself ends the older one.
            is_successive = epoch and other.epoch and other.history == history
            if is_new and not is_successive:
                known.add(other.instance)
                report(f'{name} also runs elsewhere: {where(other)}; stop one of the two')

        self._publisher = publisher(self._node, Identity, f'~/{TOPIC}', LATCHED)
        subscribe(self._node, Identity, f'~/{TOPIC}', heard, _FROM_ALL)
        self.own.cell, self.own.history, self.own.epoch = cell.name, history, epoch
        self._publisher.publish(self.own)


class Listener:
    """Hears who runs a cell under a name, on a node and an executor of its own."""

    def __init__(self, node: Node, topic: str) -> None:
        """Begin to listen in the context of a node, and under the names that it knows."""
        self._node = Node(
            f'_{node.get_name()}_identities',
            context=node.context,
            use_global_arguments=False,
            enable_rosout=False,
            start_parameter_services=False,
        )
        self._executor = SingleThreadedExecutor(context=node.context)
        self._executor.add_node(self._node)
        self._heard: dict[str, Identity] = {}
        full_name = node.resolve_topic_name(topic)
        self._topic = subscribe(self._node, Identity, full_name, self._hear, _FROM_ALL)

    def listen(
        self, is_enough: Callable[[Sequence[Identity]], bool], within_s: float
    ) -> Sequence[Identity]:
        """Return those heard when they are enough or the time is over."""
        until = time.monotonic() + within_s
        while True:
            self._executor.spin_once(timeout_sec=_STEP_S)
            heard = tuple(self._heard.values())
            if is_enough(heard) or time.monotonic() >= until:
                return heard

    @property
    def publishers(self) -> int:
        """How many are connected, those that were killed a moment ago too."""
        return int(self._topic.get_publisher_count())

    def close(self) -> None:
        """Stop listening."""
        self._executor.shutdown()
        self._node.destroy_node()

    def _hear(self, identity: Identity) -> None:
        self._heard[identity.instance] = identity


def twins_in_words(node: Node, name: str) -> str:
    """Say where all are that run a cell under a name, if there are several; else nothing."""
    listener = Listener(node, f'{name}/{TOPIC}')
    try:
        # Who was killed is still counted here and there, and says nothing.
        heard = listener.listen(lambda heard: 0 < listener.publishers <= len(heard), LOOK_S)
    finally:
        listener.close()
    return in_words(name, heard)


def in_words(name: str, identities: Sequence[Identity]) -> str:
    """Say where all are that answer to a name, if there are several; else nothing."""
    if len(identities) < 2:
        return ''
    places = '; '.join(map(where, identities))
    return sentence('twins', count=len(identities), name=name, words=places)


def where(identity: Identity) -> str:
    """Say where a process is, what it runs and since when."""
    since = datetime.fromtimestamp(identity.started.sec)
    host, cell = cut(identity.host, PLACE), cut(identity.cell, PLACE)
    time = f'{since:%Y-%m-%d %H:%M:%S}'
    return sentence('twin_place', process=identity.pid, host=host, cell=cell, time=time)
