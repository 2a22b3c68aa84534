"""One simulated component as other nodes see it: an action server and a state topic."""

from __future__ import annotations

from dataclasses import dataclass

from rclpy.node import Node

from bt_orchestrator.model.action_type import ActionType
from bt_orchestrator.model.cell import Component
from bt_orchestrator.ports import Clock
from bt_orchestrator.sim.controllers.controller import Controller, Pace
from bt_orchestrator.sim.controllers.goal_log import GoalLog
from bt_orchestrator.sim.controllers.interfaces import Interfaces
from bt_orchestrator.sim.controllers.state_publisher import StatePublisher
from bt_orchestrator.sim.controllers.task_server import TaskServer


@dataclass(frozen=True)
class Surroundings:
    """What all components of one process share."""

    node: Node
    clock: Clock
    interfaces: Interfaces
    log: GoalLog
    pace: Pace
    result_timeout_s: float | None


class ComponentServer:
    """States: present (server and publisher exist) or not. Implements `presence.Presence`.

    A death is the end of both, without an answer to anyone. Unlike a killed process they leave the
    ROS graph at once; whoever needs that difference kills the process.
    """

    def __init__(
        self, component: Component, action_type: ActionType, surroundings: Surroundings
    ) -> None:
        self._component = component
        self._with = surroundings
        self._logger = surroundings.node.get_logger().get_child(component.name)
        self._server: TaskServer | None = None
        self._state: StatePublisher | None = None
        self.controller = Controller(
            component, action_type, self, surroundings.clock, surroundings.log, surroundings.pace
        )

    def appear(self) -> None:
        """Create the action server and, if the component has one, the state topic."""
        node, interfaces = self._with.node, self._with.interfaces
        given_s = self._with.result_timeout_s
        self._server = TaskServer(
            node,
            self._component.action,
            self._component.type,
            self.controller,
            interfaces,
            self._component.result_timeout_s if given_s is None else given_s,
        )
        if self._component.state:
            self._state = StatePublisher(node, self._component.state, interfaces)

    def vanish(self) -> None:
        """Destroy both."""
        if self._server:
            self._server.destroy()
        if self._state:
            self._state.destroy()
        self._server = self._state = None

    def announce(self, ready: bool) -> None:
        """Say it on the state topic, if there is one."""
        if self._state:
            self._state.announce(ready)

    def repeat_state(self) -> None:
        """Say again what was said last."""
        if self._state:
            self._state.repeat()

    def warn(self, text: str) -> None:
        """Log it."""
        self._logger.warning(text)
