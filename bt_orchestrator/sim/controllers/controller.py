"""One simulated device controller: what it does, whatever carries its messages."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from bt_orchestrator.model.action_type import ActionType
from bt_orchestrator.model.cell import Component
from bt_orchestrator.model.fault import Fault, FaultKind
from bt_orchestrator.model.goal import GoalStatus
from bt_orchestrator.ports import Clock, Timer
from bt_orchestrator.sim.controllers.goal_log import GoalLog
from bt_orchestrator.sim.controllers.presence import ActiveGoal, Answer, Presence
from bt_orchestrator.sim.controllers.task_names import TaskNames
from bt_orchestrator.sim.fault_schedule import FaultSchedule, GoalFaults
from bt_orchestrator.sim.readiness import Readiness
from bt_orchestrator.sim.results import as_failed, simulated_result


@dataclass(frozen=True)
class Pace:
    """How fast the simulated cell runs."""

    speed: float = 1.0
    """All simulated seconds, those of faults too, are divided by this."""
    feedback_s: float = 0.5
    """Real seconds between two feedback messages of a goal; 0: only the one at its start."""


@dataclass
class _Work:
    """The task in hand."""

    goal: ActiveGoal
    task: str
    faults: GoalFaults
    began: float
    nominal_s: float
    """Real seconds that it takes."""
    end: Timer | None = None
    next_feedback: Timer | None = None


class Controller:
    """Runs one task at a time, and has the faults that its component was told to have.

    States: away (no server), idle, busy (one goal, timers running). All calls come from one
    thread, the clock's. Pure of ROS: `Presence` and `ActiveGoal` carry its messages.
    """

    def __init__(
        self,
        component: Component,
        action_type: ActionType,
        presence: Presence,
        clock: Clock,
        log: GoalLog,
        pace: Pace,
    ) -> None:
        self._component = component
        self._type = action_type
        self._presence = presence
        self._clock = clock
        self._log = log
        self._pace = pace
        self._names = TaskNames(component, action_type)
        self._schedule = FaultSchedule(component.faults)
        self._work: _Work | None = None
        self._accepted: tuple[str, str, GoalFaults] | None = None
        self._readiness = Readiness(self._schedule, presence.announce, self._after)
        self._leaving = False

    # --- life -------------------------------------------------------------------------------

    def switch_on(self) -> bool:
        """Come up, unless told to be absent; return whether the server is there."""
        absent = self._schedule.at_start(FaultKind.ABSENT)
        not_ready = self._schedule.at_start(FaultKind.NOT_READY)
        if absent is None:
            self._appear(not_ready)
        elif absent.seconds is not None:
            self._after(absent.seconds, lambda: self._appear(not_ready))
        return absent is None

    def switch_off(self) -> None:
        """Abort the task in hand and take no other, as at a proper shutdown."""
        self._leaving = True
        self._end(GoalStatus.ABORTED, {})

    def _appear(self, not_ready: Fault | None = None) -> None:
        self._record('appeared')
        self._presence.appear()
        self._readiness.begin(not_ready)

    def _die(self, fault: Fault) -> None:
        work = self._stop_work()
        about = {} if work is None else {'goal': work.goal.id, 'task': work.task}
        self._record('died', **about)
        self._presence.warn('dies, as told')
        self._presence.vanish()
        if fault.seconds is not None:
            self._after(fault.seconds, self._appear)

    # --- requests ---------------------------------------------------------------------------

    def answer(self, goal_id: str, task_value: Any) -> Answer:
        """Decide on a goal request; a goal it accepts is expected in `start`.

        :param task_value: of the goal's `task` field; None where the type has none
        """
        task = self._names.name(task_value)
        if self._work is not None:
            return self._reject(goal_id, task, f'busy with goal {self._work.goal.id}')
        if task is None:
            return self._reject(goal_id, task, f'no task constant has the value {task_value!r}')
        if self._leaving:
            return self._reject(goal_id, task, 'shutting down')
        faults = self._schedule.next_goal(task)
        if faults.has(FaultKind.MUTE):
            self._record('muted', goal=goal_id, task=task)
            return Answer.MUTE
        if faults.has(FaultKind.REJECT):
            return self._reject(goal_id, task, 'told to reject it')
        self._record('accepted', goal=goal_id, task=task)
        self._accepted = goal_id, task, faults
        return Answer.ACCEPT

    def start(self, goal: ActiveGoal) -> None:
        """Begin the task of the goal that was accepted last."""
        if self._accepted is None or self._accepted[0] != goal.id:
            raise RuntimeError(f'goal {goal.id} was not accepted')
        _, task, faults = self._accepted
        self._accepted = None
        nominal_s = (self._component.duration_s(task) + faults.late_s) / self._pace.speed
        self._work = _Work(goal, task, faults, self._clock.steady(), nominal_s)
        self._record('started', goal=goal.id, task=task)
        self._give_feedback()
        self._arm_end(self._work)

    def cancel(self, goal_id: str) -> bool:
        """Decide on a cancel request; an obeyed one ends the goal at once."""
        work = self._work
        if work is None or work.goal.id != goal_id:
            return False
        obeyed = not work.faults.has(FaultKind.IGNORE_CANCEL)
        self._record('cancel', goal=goal_id, task=work.task, obeyed=obeyed)
        if obeyed:
            self._end(GoalStatus.CANCELED, {})
        return obeyed

    def _reject(self, goal_id: str, task: str | None, why: str) -> Answer:
        named = {} if task is None else {'task': task}
        self._record('rejected', goal=goal_id, **named, why=why)
        self._presence.warn(f'rejects goal {goal_id}: {why}')
        return Answer.REJECT

    # --- the task in hand -------------------------------------------------------------------

    def _arm_end(self, work: _Work) -> None:
        """Arrange the end that the faults say."""
        fault = work.faults.ending
        kind = fault.kind if fault else None
        result = simulated_result(self._component, self._type, work.task)
        if fault and kind is FaultKind.DIE:
            # Half-way: the request was answered for certain, and the task is not done.
            self._when_worked(work, 0.5, lambda: self._die(fault))
        elif kind is FaultKind.ABORT:
            self._when_worked(work, 1.0, lambda: self._end(GoalStatus.ABORTED, {}))
        elif kind is FaultKind.CANCEL:
            self._when_worked(work, 1.0, lambda: self._end(GoalStatus.CANCELED, {}))
        elif kind in (None, FaultKind.FALSE):
            result = as_failed(result) if fault else result
            self._when_worked(work, 1.0, lambda: self._end(GoalStatus.SUCCEEDED, result))

    def _when_worked(self, work: _Work, share: float, then: Callable[[], None]) -> None:
        work.end = self._clock.call_at(work.began + share * work.nominal_s, then)

    def _give_feedback(self) -> None:
        work = self._work
        if work is None:
            return
        now = self._clock.steady()
        done = min((now - work.began) / work.nominal_s, 1.0) if work.nominal_s else 1.0
        work.goal.feedback(f'{work.task} {done:.0%}'.strip())
        later = now + self._pace.feedback_s
        if now < later < work.began + work.nominal_s:
            work.next_feedback = self._clock.call_at(later, self._give_feedback)

    def _end(self, status: GoalStatus, result: Mapping[str, Any]) -> None:
        work = self._stop_work()
        if work is None:
            return
        self._record('ended', goal=work.goal.id, task=work.task, status=status.value)
        # Before the end is told, so that nobody who hears of it believes in readiness.
        self._readiness.withdraw(work.faults.find(FaultKind.NOT_READY))
        work.goal.end(status, result)

    def _stop_work(self) -> _Work | None:
        work, self._work = self._work, None
        for timer in (work.end, work.next_feedback) if work else ():
            if timer:
                timer.cancel()
        return work

    # --- time, log --------------------------------------------------------------------------

    def _after(self, seconds: float, then: Callable[[], None]) -> Timer:
        return self._clock.call_at(self._clock.steady() + seconds / self._pace.speed, then)

    def _record(self, event: str, **fields: Any) -> None:
        self._log.write(self._clock.now(), event, self._component, **fields)
