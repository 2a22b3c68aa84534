"""The ROS 2 node that hosts simulated controllers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node

from bt_orchestrator.model.cell import Component
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.sim.controllers.clock import NodeClock
from bt_orchestrator.sim.controllers.component_server import ComponentServer, Surroundings
from bt_orchestrator.sim.controllers.goal_log import GoalLog
from bt_orchestrator.sim.controllers.interfaces import Interfaces
from bt_orchestrator.sim.controllers.pace import Pace

NODE_NAME = 'sim_cell'
STATE_PERIOD_S = 1.0


@dataclass(frozen=True)
class Setup:
    """The components to simulate, and the way."""

    components: Sequence[Component]
    types: ActionTypes
    interfaces: Interfaces
    log: GoalLog
    pace: Pace = field(default_factory=Pace)
    namespace: str = ''
    result_timeout_s: float | None = None
    """Seconds for which a server remembers an ended goal; None: as the cell file says."""


class ControllerNode(Node):
    """Hosts one action server a component; a process is one node and one DDS participant.

    Belongs on a SingleThreadedExecutor: on the events executor servers were seen to stall.
    """

    def __init__(self, setup: Setup) -> None:
        # Parameter services are six more DDS entities for nothing to set.
        super().__init__(NODE_NAME, namespace=setup.namespace, start_parameter_services=False)
        surroundings = Surroundings(
            self,
            NodeClock(self),
            setup.interfaces,
            setup.log,
            setup.pace,
            setup.result_timeout_s,
        )
        self._servers = [
            ComponentServer(component, setup.types.action(component.type), surroundings)
            for component in setup.components
        ]
        self._present = [server.controller.switch_on() for server in self._servers]
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(STATE_PERIOD_S, self._repeat_states, clock=steady)

    @property
    def ready_line(self) -> str:
        """The line that is printed once every server is up."""
        up, absent = sum(self._present), self._present.count(False)
        text = f'{up} action server{"" if up == 1 else "s"}'
        return f'{text}, {absent} absent at first' if absent else text

    def switch_off(self) -> None:
        """Abort the tasks in hand."""
        for server in self._servers:
            server.controller.switch_off()

    def _repeat_states(self) -> None:
        for server in self._servers:
            server.repeat_state()
