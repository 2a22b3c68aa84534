"""The state topic of one simulated controller (semantics 2.5)."""

from __future__ import annotations

from typing import Any

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from bt_orchestrator.model.cell import StateTopic
from bt_orchestrator.sim.controllers.interfaces import Interfaces
from bt_orchestrator.sim.results import not_ready_value, ready_value

LATCHED = QoSProfile(
    depth=1,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)
"""Late subscribers get the last value."""


class StatePublisher:
    """Publishes whether the controller is ready, from the first known value on."""

    def __init__(self, node: Node, state: StateTopic, interfaces: Interfaces) -> None:
        self._node = node
        self._state = state
        self._interfaces = interfaces
        self._class = interfaces.message_class(state.type)
        self._publisher = node.create_publisher(self._class, state.topic, LATCHED)
        self._last: Any = None

    def announce(self, ready: bool) -> None:
        """Publish a new value."""
        value = ready_value(self._state) if ready else not_ready_value(self._state)
        self._last = self._class()
        self._interfaces.fill(self._last, nested(self._state.field, value))
        self.repeat()

    def repeat(self) -> None:
        """Publish the last value again, for subscribers that did not ask for a latched topic."""
        if self._last is not None:
            self._publisher.publish(self._last)

    def destroy(self) -> None:
        """Leave the topic."""
        self._node.destroy_publisher(self._publisher)


def nested(path: str, value: Any) -> dict[str, Any]:
    """Return the mapping that sets a field path such as `status.mode`."""
    name, _, inner = path.partition('.')
    return {name: nested(inner, value) if inner else value}
