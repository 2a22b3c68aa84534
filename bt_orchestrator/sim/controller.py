"""One simulated device controller: what it does with goals, and its faults.

The same one in virtual time and behind real action servers: it knows a clock and a `Carrier`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Generic, TypeVar

from bt_orchestrator.model.action_type import TASK_RESULT, ActionType
from bt_orchestrator.model.cell import Component
from bt_orchestrator.model.fault import Fault, FaultKind
from bt_orchestrator.model.goal import GoalEnd, GoalRequest, GoalStatus
from bt_orchestrator.model.jobs.setups import change_by
from bt_orchestrator.ports import Clock, Timer
from bt_orchestrator.sim.carrier import Answer, CarriedGoal, Carrier, Verdict
from bt_orchestrator.sim.faults import FaultSchedule, GoalFaults
from bt_orchestrator.sim.results import (
    NUMBER,
    as_failed,
    as_read,
    numbered,
    saying,
    simulated_result,
)

GoalT = TypeVar('GoalT', bound=CarriedGoal)

_ACCEPT, _MUTE = Answer(Verdict.ACCEPT), Answer(Verdict.MUTE)
_ABORTED = GoalEnd(GoalStatus.ABORTED, message='aborted by the simulated controller')
_CANCELED = GoalEnd(GoalStatus.CANCELED, message='canceled as requested')
_SELF_CANCELED = GoalEnd(GoalStatus.CANCELED, message='canceled by the simulated controller')


@dataclass(slots=True)
class _Work(Generic[GoalT]):
    """The task in hand."""

    goal: GoalT
    faults: GoalFaults
    began_s: float
    takes_s: float
    end: Timer | None = None
    next_feedback: Timer | None = None


_Ending = Callable[['Controller[Any]', _Work[Any], Fault], None]


class Controller(Generic[GoalT]):
    """Runs one task at a time, with the configured faults of its component.

    States: away (no server), idle, busy (one goal, timers running). All calls come from one
    thread, the clock's.
    """

    def __init__(
        self,
        component: Component,
        action_type: ActionType,
        carrier: Carrier[GoalT],
        clock: Clock,
        duration: Callable[[GoalRequest], float],
        feedback_s: float = 0.0,
        setups: Mapping[str, str] | None = None,
    ) -> None:
        """Be away until it is switched on.

        :param duration: seconds that a goal takes
        :param setups: what it is set up for at first, of setups that its state topic tells
        :param feedback_s: seconds between two feedback messages; 0: only the one at the start
        """
        self._component = component
        self._type = action_type
        self._carrier = carrier
        self._clock = clock
        self._duration = duration
        self._feedback_s = feedback_s
        self._schedule = FaultSchedule(component.faults)
        self._readiness = Readiness(self._schedule, carrier.announce, self._after)
        self._accepted: tuple[str, GoalFaults] | None = None
        self._work: _Work[GoalT] | None = None
        self._successes: dict[str, GoalEnd] = {}
        """The successful end of each task that was begun."""
        self._counts = NUMBER in str(component.results)
        self._leaving = False
        self._setups = {
            setup: made.read_as.get((setups or {}).get(setup, ''), made.unset)
            for setup, made in component.setups.items()
            if made.reads
        }
        """The words of the state topic about setups."""

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
        self._end(_ABORTED)

    def _appear(self, not_ready: Fault | None = None) -> None:
        self._carrier.note('appeared')
        self._carrier.appear()
        for setup, value in self._setups.items():
            self._carrier.show(setup, value)
        self._readiness.begin(not_ready)

    # --- requests ---------------------------------------------------------------------------

    def answer(self, request: GoalRequest) -> Answer:
        """Decide on a goal request; a goal it accepts is expected in `start`."""
        if self._work is not None:
            return self._reject(request, f'busy with goal {self._work.goal.request.id}')
        if self._leaving:
            return self._reject(request, 'shutting down')
        faults = self._schedule.next_goal(request.task)
        if faults.has(FaultKind.MUTE):
            self._carrier.note('muted', request)
            return _MUTE
        if faults.has(FaultKind.REJECT):
            return self._reject(request, 'refused by the simulated controller')
        self._carrier.note('accepted', request)
        self._accepted = request.id, faults
        return _ACCEPT

    def start(self, goal: GoalT) -> None:
        """Begin the task of the goal that was accepted last."""
        request = goal.request
        if self._accepted is None or self._accepted[0] != request.id:
            raise RuntimeError(f'goal {request.id} was not accepted')
        (_, faults), self._accepted = self._accepted, None
        takes_s = self._duration(request) + faults.late_s
        self._work = work = _Work(goal, faults, self._clock.steady(), takes_s)
        self._carrier.note('started', request)
        self._give_feedback()
        fault = faults.find(*self._endings)
        if fault is None:
            self._end_in_time(work, self._success(request.task, faults.goal))
        else:
            self._endings[fault.kind](self, work, fault)

    def cancel(self, goal_id: str) -> bool:
        """Decide on a cancel request; an obeyed one ends the goal at once."""
        work = self._work
        if work is None or work.goal.request.id != goal_id:
            return False
        obeyed = not work.faults.has(FaultKind.IGNORE_CANCEL)
        self._carrier.note('cancel', work.goal.request, obeyed=obeyed)
        if obeyed:
            self._end(_CANCELED)
        return obeyed

    def _reject(self, request: GoalRequest, why: str) -> Answer:
        self._carrier.note('rejected', request, why=why)
        return Answer(Verdict.REJECT, why)

    # --- how an accepted goal goes on -------------------------------------------------------

    def _false(self, work: _Work[GoalT], fault: Fault) -> None:
        good = self._success(work.goal.request.task, work.faults.goal)
        result = {**as_failed(good.result), **saying(self._type, fault.words)}
        self._end_in_time(work, replace(good, result=result))

    def _read(self, work: _Work[GoalT], fault: Fault) -> None:
        number = math.nan if fault.seconds is None else fault.seconds
        goal = int(number) if math.isfinite(number) else work.faults.goal
        good = self._success(work.goal.request.task, goal)
        self._end_in_time(work, replace(good, result=as_read(good.result, number)))

    def _abort(self, work: _Work[GoalT], fault: Fault) -> None:
        self._end_in_time(work, replace(_ABORTED, result=saying(self._type, fault.words)))

    def _cancel_unasked(self, work: _Work[GoalT], fault: Fault) -> None:
        self._end_in_time(work, replace(_SELF_CANCELED, result=saying(self._type, fault.words)))

    def _hang(self, work: _Work[GoalT], _: Fault) -> None:
        """Arm nothing."""

    def _die_half_way(self, work: _Work[GoalT], fault: Fault) -> None:
        """Die when the request was answered for certain, and the task is not done."""
        self._when_worked(work, 0.5, lambda: self._die(fault))

    def _die(self, fault: Fault) -> None:
        work = self._stop_work()
        self._carrier.note('died', work.goal.request if work else None)
        self._carrier.vanish()
        if fault.seconds is not None:
            self._after(fault.seconds, self._appear)

    _endings: ClassVar[Mapping[FaultKind, _Ending]] = {
        FaultKind.FALSE: _false,
        FaultKind.READS: _read,
        FaultKind.ABORT: _abort,
        FaultKind.CANCEL: _cancel_unasked,
        FaultKind.HANG: _hang,
        FaultKind.IGNORE_CANCEL: _hang,
        FaultKind.DIE: _die_half_way,
    }
    """Of several that strike at one goal, the first one listed counts."""

    # --- the task in hand -------------------------------------------------------------------

    def _success(self, task: str, goal: int) -> GoalEnd:
        if task not in self._successes:
            result = simulated_result(self._component, self._type, task)
            self._successes[task] = GoalEnd(GoalStatus.SUCCEEDED, result)
        good = self._successes[task]
        return replace(good, result=numbered(good.result, goal)) if self._counts else good

    def _end_in_time(self, work: _Work[GoalT], end: GoalEnd) -> None:
        self._when_worked(work, 1.0, lambda: self._end(end))

    def _when_worked(self, work: _Work[GoalT], share: float, then: Callable[[], None]) -> None:
        work.end = self._clock.call_at(work.began_s + share * work.takes_s, then)

    def _give_feedback(self) -> None:
        work = self._work
        if work is None:
            return
        now_s = self._clock.steady()
        done = min((now_s - work.began_s) / work.takes_s, 1.0) if work.takes_s else 1.0
        self._carrier.feedback(work.goal, done)
        later_s = now_s + self._feedback_s
        if now_s < later_s < work.began_s + work.takes_s:
            work.next_feedback = self._clock.call_at(later_s, self._give_feedback)

    def _end(self, end: GoalEnd) -> None:
        work = self._stop_work()
        if work is None:
            return
        self._carrier.note('ended', work.goal.request, status=end.status.value)
        # Before the end is reported, so that no client sees it and still assumes readiness.
        self._set_up(work.goal.request, end)
        self._readiness.withdraw(work.faults.find(FaultKind.NOT_READY))
        self._carrier.end(work.goal, end)

    def _set_up(self, request: GoalRequest, end: GoalEnd) -> None:
        """Show what a change has set, where the state topic tells it."""
        change = change_by(self._component, request.task, request.args) if self._setups else None
        is_done = end.status is GoalStatus.SUCCEEDED and end.result.get(TASK_RESULT, True)
        if change is not None and is_done and change.setup in self._setups:
            self.set_up(change.setup, change.value)

    def set_up(self, setup: str, value: str) -> None:
        """Have a setup, and show it on the state topic."""
        self._setups[setup] = self._component.setups[setup].read_as.get(value, value)
        self._carrier.show(setup, self._setups[setup])

    def _stop_work(self) -> _Work[GoalT] | None:
        work, self._work = self._work, None
        for timer in (work.end, work.next_feedback) if work else ():
            if timer:
                timer.cancel()
        return work

    def _after(self, seconds: float, then: Callable[[], None]) -> Timer:
        return self._clock.call_at(self._clock.steady() + seconds, then)


# When a simulated controller says that it is ready.


class Readiness:
    """Ready whenever it comes up, but for the faults; silent all the time if told so."""

    def __init__(
        self,
        schedule: FaultSchedule,
        announce: Callable[[bool], None],
        after: Callable[[float, Callable[[], None]], Timer],
    ) -> None:
        """Begin without a word.

        :param announce: shows whether it is ready
        :param after: calls back in so many simulated seconds
        """
        self._schedule = schedule
        self._announce = announce
        self._after = after
        self._ready_again: Timer | None = None

    def begin(self, not_ready: Fault | None) -> None:
        """Say how it is when the server comes up."""
        if not_ready is None:
            self._say(ready=True)
        self.withdraw(not_ready)

    def withdraw(self, fault: Fault | None) -> None:
        """Become not ready, for as long as the fault says."""
        if fault is None:
            return
        if self._ready_again is not None:
            self._ready_again.cancel()
        self._say(ready=False)
        if fault.seconds is not None:
            self._ready_again = self._after(fault.seconds, lambda: self._say(ready=True))

    def _say(self, *, ready: bool) -> None:
        if self._schedule.at_start(FaultKind.SILENT) is None:
            self._announce(ready)
