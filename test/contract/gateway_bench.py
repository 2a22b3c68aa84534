"""What a gateway's contract needs of the world around the gateway."""

from __future__ import annotations

import uuid
from collections.abc import Callable, Sequence, Sized
from typing import Any, Protocol

from bt_orchestrator.model.cell import Cell, Component, Conveyor, Setup, StateTopic
from bt_orchestrator.model.fault import parse_fault
from bt_orchestrator.model.goal import GoalRequest, SetupReading, StateReading
from bt_orchestrator.ports import ActionGateway, Told

COMPONENT_TYPE = 'bt_orchestrator_interfaces/action/Component'
CONVEYOR_TYPE = 'bt_orchestrator_interfaces/action/Conveyor'

TASK_S = 0.2
"""Nominal seconds of a task."""

SERVER_TIMEOUT_S = 5.0
"""Fast DDS needs up to 3 s to find a process whose first announcements were lost."""


class Bench(Protocol):
    """A gateway, the cell at its other end, and time."""

    @property
    def gateway(self) -> ActionGateway:
        """What is tested."""

    @property
    def now(self) -> float:
        """Seconds, from any zero."""

    def run_until(self, condition: Callable[[], Any], what: str, within_s: float = 60.0) -> None:
        """Let things happen until a condition holds; fails if it does not in time."""

    def run_for(self, seconds: float) -> None:
        """Let things happen for some time."""

    def run_to_settle(self, woken: Sized, within_s: float) -> None:
        """Let things happen until an engine would settle; fails if that is too late.

        :param woken: an engine in real time settles when this has entries, one in virtual time
            whenever the clock has moved
        """

    def close(self) -> None:
        """Put everything away."""


GRIPPER = Setup(
    values={'small': 'small', 'large': 'large'},
    task='TASK_A',
    argument='special_argument_1',
    reads='value',
    read_as={'small': 'small', 'large': 'large'},
)
"""A setup that the state topic tells."""


def component(
    name: str, *faults: str, state: bool = False, task_s: float = TASK_S, tells: bool = False
) -> Component:
    """Describe a component of the example type, with faults as users write them.

    :param tells: its state topic tells `GRIPPER`
    """
    topic = StateTopic(f'/{name}/state', 'std_msgs/msg/String', 'data', ('READY',))
    if tells:
        kind = 'diagnostic_msgs/msg/KeyValue'
        topic = StateTopic(f'/{name}/state', kind, 'key', ('READY',))
    return Component(
        name=name,
        sections=(1,),
        action=f'/{name}/task',
        type=COMPONENT_TYPE,
        state=topic if state or tells else None,
        setups={'gripper': GRIPPER} if tells else {},
        durations_s={'TASK_A': task_s, 'TASK_B': 4 * task_s},
        results={'TASK_A': {'measurement': 1.5}},
        faults=tuple(parse_fault(fault) for fault in faults),
    )


def cell_of(components: Sequence[Component]) -> Cell:
    """Return a cell with these components, and a conveyor that nobody uses."""
    belt = Component('conveyor', (), '/conveyor/index', CONVEYOR_TYPE)
    conveyor = Conveyor(1, belt, 'MOVE_ONE_INDEX')
    return Cell('bench', conveyor, {c.name: c for c in (*components, belt)})


def goal_request(component: str, task: str = 'TASK_A', **args: Any) -> GoalRequest:
    """Return a request with a new UUID."""
    return GoalRequest(str(uuid.uuid4()), component, task, args)


class Log:
    """Everything that a gateway told, in order."""

    def __init__(self, gateway: ActionGateway) -> None:
        self._gateway = gateway
        self.entries: list[Told] = []

    def update(self) -> list[Told]:
        """Drain the gateway; return what was new."""
        new = list(self._gateway.drain())
        self.entries += new
        return new

    def readings(self, component: str) -> list[Any]:
        """Return the values told of one state topic."""
        self.update()
        return [
            entry.value
            for entry in self.entries
            if isinstance(entry, StateReading) and entry.component == component
        ]

    def setups(self, component: str) -> list[str | None]:
        """Return the values told of the setup of one component."""
        self.update()
        return [
            entry.value
            for entry in self.entries
            if isinstance(entry, SetupReading) and entry.component == component
        ]
