"""One simulated component as other nodes see it: an action server and a state topic."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from time import monotonic
from typing import Any

from rclpy.clock import Clock as RosClock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.model.action_type import TASK, ActionType
from bt_orchestrator.model.cell import Component, SafetyInput, StateTopic
from bt_orchestrator.model.goal import RESULT_TIMEOUT_S, GoalEnd, GoalRequest
from bt_orchestrator.ports import Clock
from bt_orchestrator.sim.carrier import Verdict
from bt_orchestrator.sim.controller import Controller
from bt_orchestrator.sim.controllers.options import Pace, PacedClock
from bt_orchestrator.sim.controllers.task_server import Interfaces, TaskServer
from bt_orchestrator.sim.results import not_ready_value, ready_value


class UnusableLog(OrchestratorError):
    """The file cannot be written."""


class GoalLog:
    """Appends one line an event to a file; nothing without a file.

    A line is written at once and in one piece, before its effect leaves the process, so that
    several processes can share a file and a killed one leaves no half told story. Records:

    - `accepted`, `rejected` (with `why`), `muted`: how a goal request was answered
    - `started`: the work began; `ended` (with `status`): it is over, as the server will report it
    - `cancel` (with `obeyed`): a cancel request came
    - `died`: the server went away, with the goal it had, if any; `appeared`: it is (again) there

    Every record has `time` (seconds since the epoch, or simulated time), `steady` (seconds of the
    machine's monotonic clock, for measuring), `event`, `component` and `action`; those about a
    goal also `goal` (its UUID) and `task`.
    """

    def __init__(self, path: Path | None) -> None:
        """Open the file.

        :raises UnusableLog: it cannot be written
        """
        try:
            # Without a buffer each line is handed to the system in one write.
            self._file = None if path is None else path.open('ab', buffering=0)
        except OSError as error:
            raise UnusableLog(
                f'cannot write the log {path}: {error.strerror}; check the path'
            ) from error

    def write(self, time: float, event: str, component: Component, **fields: Any) -> None:
        """Append one record.

        :raises UnusableLog: it cannot be written
        """
        if self._file is None:
            return
        where = {'component': component.name, 'action': component.action}
        stamps = {'time': round(time, 6), 'steady': round(monotonic(), 6)}
        record = {**stamps, 'event': event, **where, **fields}
        try:
            self._file.write(f'{json.dumps(record)}\n'.encode())
        except OSError as error:
            raise UnusableLog(f'cannot write the log: {error.strerror}; check its disk') from error

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            self._file.close()


SIMULATED_RESULT_TIMEOUT_S = 60.0
"""Seconds for which a simulated server remembers an ended goal where the cell file says nothing:
long enough for a node that is started again by hand."""


@dataclass(frozen=True)
class Surroundings:
    """The things that all components of one process share."""

    node: Node
    clock: Clock
    interfaces: Interfaces
    log: GoalLog
    pace: Pace
    result_timeout_s: float | None


@dataclass(frozen=True)
class ServedGoal:
    """One accepted goal of a `TaskServer`. Implements `carrier.CarriedGoal`."""

    request: GoalRequest
    handle: Any


class ComponentServer:
    """States: present (server and publisher exist) or not.

    Carries the messages of one controller: implements `carrier.Carrier` on its side, and
    `task_server.Requests` on the other. A death is the end of server and publisher, without an
    answer to anyone. Unlike a killed process they leave the ROS graph at once; to test that
    difference, kill the process.
    """

    def __init__(
        self, component: Component, action_type: ActionType, surroundings: Surroundings
    ) -> None:
        self._component = component
        self._with = surroundings
        self._names = TaskNames(component, action_type)
        self._logger = surroundings.node.get_logger().get_child(component.name)
        self._server: TaskServer | None = None
        self._state: StatePublisher | None = None
        pace = surroundings.pace
        self.controller = Controller[ServedGoal](
            component,
            action_type,
            self,
            PacedClock(surroundings.clock, pace.speed),
            lambda request: component.duration_s(request.task),
            pace.feedback_s * pace.speed,
        )

    # --- what the controller shows ----------------------------------------------------------

    def appear(self) -> None:
        """Create the action server and, if the component has one, the state topic."""
        node, interfaces = self._with.node, self._with.interfaces
        self._server = TaskServer(
            node,
            self._component.action,
            self._component.type,
            self,
            interfaces,
            self._remembers_s(),
        )
        if self._component.state:
            self._state = StatePublisher(node, self._component.state, interfaces)

    def _remembers_s(self) -> float:
        """Return for how long an ended goal is remembered: as asked, else by the cell file."""
        if self._with.result_timeout_s is not None:
            return self._with.result_timeout_s
        said_s = self._component.result_timeout_s
        return said_s if said_s != RESULT_TIMEOUT_S else SIMULATED_RESULT_TIMEOUT_S

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

    def show(self, setup: str, value: Any) -> None:
        """Say what a setup is on the state topic."""
        if self._state:
            self._state.show(self._component.setups[setup].reads, value)

    def repeat_state(self) -> None:
        """Say again what was said last."""
        if self._state:
            self._state.repeat()

    def feedback(self, goal: ServedGoal, done: float) -> None:
        """Publish it."""
        if self._server:
            self._server.feedback(goal.handle, f'{goal.request.task} {done:.0%}'.strip())

    def end(self, goal: ServedGoal, end: GoalEnd) -> None:
        """End a goal; a ROS 2 server has no words of its own for it."""
        if self._server:
            self._server.end(goal.handle, end.status, end.result)

    def note(self, event: str, request: GoalRequest | None = None, **about: Any) -> None:
        """Append it to the log; tell a person of what is amiss."""
        if request is not None:
            about = {'goal': request.id, 'task': request.task, **about}
        self._with.log.write(self._with.clock.now(), event, self._component, **about)
        if event == 'rejected':
            text = f'rejects goal {about["goal"]}: {about["why"]}'
            self._logger.warning(text)
        elif event == 'died':
            self._logger.warning('dies, as told')

    # --- what clients ask -------------------------------------------------------------------

    def answer(self, goal_id: str, message: Any) -> Verdict:
        """Let the controller decide, if there is a name for the task."""
        value = getattr(message, TASK, None)
        task = self._names.name(value)
        if task is None:
            self.note('rejected', goal=goal_id, why=f'no task constant has the value {value!r}')
            return Verdict.REJECT
        return self.controller.answer(GoalRequest(goal_id, self._component.name, task)).verdict

    def start(self, goal_id: str, handle: Any) -> None:
        """Begin what was accepted."""
        task = self._names.name(getattr(handle.request, TASK, None))
        assert task is not None, 'it was accepted'
        fields = {
            setup.argument for setup in self._component.setups.values() if setup.task == task
        }
        args = {field: getattr(handle.request, field) for field in fields}
        request = GoalRequest(goal_id, self._component.name, task, args)
        self.controller.start(ServedGoal(request, handle))

    def cancel(self, goal_id: str) -> bool:
        """Let the controller decide."""
        return self.controller.cancel(goal_id)


# From the value of a goal's `task` field back to the name of its constant.


class TaskNames:
    """The tasks of one component, as its action server sees them.

    A type without a `task` field carries no name over the wire: its label is known here only if
    the cell file mentions exactly one for this component (in `durations` or `results`).
    """

    def __init__(self, component: Component, action_type: ActionType) -> None:
        mentioned = {*component.durations_s, *component.results}
        self._label = mentioned.pop() if len(mentioned) == 1 else ''
        self._has_task_field = action_type.has_task_field
        self._constants = dict(action_type.constants)
        # Several constants may share a value; the cell file tells which of them are tasks.
        preferred = sorted(self._constants, key=lambda name: name not in component.durations_s)
        self._by_value = {self._constants[name]: name for name in reversed(preferred)}

    def name(self, value: Any) -> str | None:
        """Return the name for a goal's task value; None if no constant has this value.

        :param value: of the goal's `task` field; ignored where the type has none
        """
        if not self._has_task_field:
            return self._label
        return self._by_value.get(value) if self._constants else str(value)


# The state topic of one simulated controller (semantics 2.5).

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
        self._setups: dict[str, Any] = {}
        """Values of the fields that tell setups."""

    def announce(self, ready: bool) -> None:
        """Publish a new value."""
        value = ready_value(self._state) if ready else not_ready_value(self._state)
        self._last = self._class()
        for field, content in {**self._setups, self._state.field: value}.items():
            self._interfaces.fill(self._last, nested(field, content))
        self.repeat()

    def show(self, field: str, value: Any) -> None:
        """Publish another value of a field that tells a setup, once anything was published."""
        self._setups[field] = value
        if self._last is not None:
            self._interfaces.fill(self._last, nested(field, value))
            self.repeat()

    def repeat(self) -> None:
        """Publish the last value again, for subscribers that did not ask for a latched topic."""
        if self._last is not None:
            self._publisher.publish(self._last)

    def destroy(self) -> None:
        """Leave the topic."""
        self._node.destroy_publisher(self._publisher)


class SafetyPublisher:
    """Says again and again that the line is safe; it is simulated, as the controllers are."""

    def __init__(self, node: Node, safety: SafetyInput, interfaces: Interfaces) -> None:
        message = interfaces.message_class(safety.type)()
        interfaces.fill(message, nested(safety.field, ready_value(safety)))
        publisher = node.create_publisher(type(message), safety.topic, 1)
        steady = RosClock(clock_type=ClockType.STEADY_TIME)
        node.create_timer(safety.within_s / 5, lambda: publisher.publish(message), clock=steady)


def nested(path: str, value: Any) -> dict[str, Any]:
    """Return the mapping that sets a field path such as `status.mode`."""
    name, _, inner = path.partition('.')
    return {name: nested(inner, value) if inner else value}
