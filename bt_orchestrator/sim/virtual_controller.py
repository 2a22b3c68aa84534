"""A device controller in virtual time: what it does with goals, and its faults."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

from bt_orchestrator.model.action_type import ActionType
from bt_orchestrator.model.cell import Component
from bt_orchestrator.model.fault import Fault, FaultKind
from bt_orchestrator.model.goal import GoalEnd, GoalRequest, GoalStatus
from bt_orchestrator.ports import Clock, Timer
from bt_orchestrator.sim.fault_schedule import FaultSchedule, GoalFaults
from bt_orchestrator.sim.readiness import Readiness
from bt_orchestrator.sim.results import as_failed, not_ready_value, ready_value, simulated_result
from bt_orchestrator.sim.virtual_goal import VirtualGoal

_SELF_MADE_ENDS = {
    FaultKind.ABORT: GoalEnd(GoalStatus.ABORTED, message='aborted by the simulated controller'),
    FaultKind.CANCEL: GoalEnd(GoalStatus.CANCELED, message='canceled by the simulated controller'),
}
_CANCELED = GoalEnd(GoalStatus.CANCELED, message='canceled as requested')


class Observer(Protocol):
    """Who sees what the controller shows to the outside."""

    def appeared(self) -> None:
        """The action server is there."""

    def vanished(self) -> None:
        """The action server died; nobody was told."""

    def announced(self, value: Any) -> None:
        """The state topic says a value."""

    def accepted(self, goal: VirtualGoal, feedback: Mapping[str, Any] | None) -> None:
        """The server said yes."""

    def ended(self, goal: VirtualGoal, end: GoalEnd) -> None:
        """The server refused or ended a goal."""


class VirtualController:
    """States: away, idle, busy with one goal.

    The twin of `sim.controllers.controller`, which shows itself to ROS 2: faults mean the same.
    """

    def __init__(
        self,
        component: Component,
        action_type: ActionType,
        clock: Clock,
        duration: Callable[[GoalRequest], float],
        observer: Observer,
    ) -> None:
        self._component = component
        self._type = action_type
        self._clock = clock
        self._duration = duration
        self._observer = observer
        self._schedule = FaultSchedule(component.faults)
        self._goal: VirtualGoal | None = None
        self._faults = GoalFaults()
        self._readiness = Readiness(self._schedule, self._announce, self._after)
        self._results: dict[str, Mapping[str, Any]] = {}
        """Of each task, once it was done; nobody changes them."""
        self.present = False

    def switch_on(self) -> None:
        """Come up, unless told to be absent."""
        absent = self._schedule.at_start(FaultKind.ABSENT)
        not_ready = self._schedule.at_start(FaultKind.NOT_READY)
        if absent is None:
            self._appear(not_ready)
        elif absent.seconds is not None:
            self._after(absent.seconds, lambda: self._appear(not_ready))

    def request(self, goal: VirtualGoal) -> None:
        """Decide on a goal request, which may stay without an answer."""
        if not self.present:
            return
        if self._goal is not None:
            self._refuse(goal, f'busy with goal {self._goal.request.id}')
            return
        faults = self._schedule.next_goal(goal.request.task)
        if faults.has(FaultKind.REJECT):
            self._refuse(goal, 'refused by the simulated controller')
        elif not faults.has(FaultKind.MUTE):
            self._start(goal, faults)

    def cancel(self, goal: VirtualGoal) -> None:
        """Obey a cancel request, unless told otherwise."""
        if goal is self._goal and not self._faults.has(FaultKind.IGNORE_CANCEL):
            self._end(goal, _CANCELED)

    def _refuse(self, goal: VirtualGoal, why: str) -> None:
        self._observer.ended(goal, GoalEnd(GoalStatus.REJECTED, message=why))

    def _start(self, goal: VirtualGoal, faults: GoalFaults) -> None:
        self._goal, self._faults = goal, faults
        task = goal.request.task
        # What feedback an action type has is not part of its description; a type whose goals
        # select a task has, by the convention of the examples, this field.
        tells = self._type.has_task_field
        fields = {'current_sub_task': task}
        self._observer.accepted(goal, fields if tells else None)
        self._arm_end(goal)

    def _arm_end(self, goal: VirtualGoal) -> None:
        seconds = self._duration(goal.request) + self._faults.late_s
        fault = self._faults.ending
        if fault is None or fault.kind is FaultKind.FALSE:
            goal.timer = self._after(seconds, lambda: self._end(goal, self._success(goal)))
        elif fault.kind is FaultKind.DIE:
            goal.timer = self._after(seconds / 2, lambda: self._die(fault))
        elif fault.kind in _SELF_MADE_ENDS:
            end = _SELF_MADE_ENDS[fault.kind]
            goal.timer = self._after(seconds, lambda: self._end(goal, end))

    def _success(self, goal: VirtualGoal) -> GoalEnd:
        task = goal.request.task
        if task not in self._results:
            self._results[task] = simulated_result(self._component, self._type, task)
        result = self._results[task]
        failed = self._faults.has(FaultKind.FALSE)
        return GoalEnd(GoalStatus.SUCCEEDED, as_failed(result) if failed else result)

    def _end(self, goal: VirtualGoal, end: GoalEnd) -> None:
        goal.stop_timer()
        self._goal = None
        # Before the end is told, so that nobody who hears of it believes in readiness.
        self._readiness.withdraw(self._faults.find(FaultKind.NOT_READY))
        self._observer.ended(goal, end)

    def _die(self, fault: Fault) -> None:
        self._goal = None
        self.present = False
        self._observer.vanished()
        if fault.seconds is not None:
            self._after(fault.seconds, self._appear)

    def _appear(self, not_ready: Fault | None = None) -> None:
        self.present = True
        self._readiness.begin(not_ready)
        self._observer.appeared()

    def _announce(self, ready: bool) -> None:
        state = self._component.state
        if state and self.present:
            self._observer.announced(ready_value(state) if ready else not_ready_value(state))

    def _after(self, seconds: float, then: Callable[[], None]) -> Timer:
        return self._clock.call_at(self._clock.steady() + seconds, then)
