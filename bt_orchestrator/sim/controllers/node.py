"""The ROS 2 node that hosts simulated controllers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, cast

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node

from bt_orchestrator.base.deadlines import NS_PER_S, Deadline, Deadlines, instant_ns
from bt_orchestrator.model.cell import Component, SafetyInput
from bt_orchestrator.model.uptime import Uptime
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.sim.controllers.component_server import (
    ComponentServer,
    GoalLog,
    SafetyPublisher,
    Surroundings,
)
from bt_orchestrator.sim.controllers.options import Pace
from bt_orchestrator.sim.controllers.task_server import Interfaces, guarded

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
    safety: SafetyInput | None = None
    """The safety input that this process publishes; None: none, or another process does."""
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
        if setup.safety is not None:
            SafetyPublisher(self, setup.safety, setup.interfaces)
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


# The `Clock` port on a ROS 2 node: any number of deadlines on one ROS timer.

_FAR_S = 3600.0


class NodeClock:
    """Time of a node: the system's, or simulated with `use_sim_time`. Implements `ports.Clock`.

    Deadlines are on the steady clock, or in simulated time if the node begins with that.

    One timer for all, because every ROS timer is looked at in every turn of the executor. To be
    used in the executor's thread only.
    """

    def __init__(self, node: Node) -> None:
        self._clock = cast('Any', node.get_clock())
        self._steady = self._clock
        if not self._clock.ros_time_is_active:
            self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._logger = node.get_logger()
        self._deadlines = Deadlines()
        self._timer = node.create_timer(_FAR_S, self._ring, clock=self._steady, autostart=False)

    def now(self) -> float:
        """Return seconds since the epoch, or the simulated time."""
        return int(self._clock.now().nanoseconds) / NS_PER_S

    def steady(self) -> float:
        """Return seconds of the steady clock, or the simulated time."""
        return self._steady_ns() / NS_PER_S

    def uptime(self) -> Uptime | None:
        """Return None: simulated controllers do not use it."""
        return None

    def call_at(self, time: float, callback: Callable[[], None]) -> Deadline:
        """Call back once `steady()` has reached a time; never before this call has returned."""
        deadline = self._deadlines.add(instant_ns(time), callback)
        self._arm()
        return deadline

    def _ring(self) -> None:
        self._timer.cancel()
        now_ns = self._steady_ns()
        while callback := self._deadlines.pop_due(now_ns):
            guarded(callback, self._logger)
        self._arm()

    def _arm(self) -> None:
        due_ns = self._deadlines.next_ns()
        if due_ns is None:
            self._timer.cancel()
            return
        self._timer.timer_period_ns = max(due_ns - self._steady_ns(), 0)
        self._timer.reset()

    def _steady_ns(self) -> int:
        return int(self._steady.now().nanoseconds)
