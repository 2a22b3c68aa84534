"""The orchestrator's end of one action, in virtual time: waiting for the server and losing it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from bt_orchestrator.base.deadlines import has_come, instant_ns
from bt_orchestrator.model.action_type import ActionType
from bt_orchestrator.model.cell import Component
from bt_orchestrator.model.goal import (
    REQUEST_CHECKS,
    RESULT_CHECK_S,
    SERVER_LEASE_S,
    WITHDRAWN,
    Contest,
    GoalEnd,
    GoalRequest,
    GoalStatus,
    SeenContest,
    SetupReading,
    StateReading,
)
from bt_orchestrator.model.words import sentence
from bt_orchestrator.ports import Clock, Timer
from bt_orchestrator.ports.news import News
from bt_orchestrator.sim.carrier import Verdict
from bt_orchestrator.sim.controller import Controller
from bt_orchestrator.sim.results import not_ready_value, ready_value

_UNKNOWN = 'the server does not know the goal (any more)'


class VirtualClient:
    """States: the server is known to the graph or not; a killed one still is, for its lease.

    Carries the messages of the component's controller (`carrier.Carrier`). Ends goals when the ROS
    gateway would (semantics 9.3), with timers only where something is amiss.
    """

    def __init__(
        self,
        component: Component,
        action_type: ActionType,
        clock: Clock,
        news: News,
        server_timeout_s: float,
        duration: Callable[[GoalRequest], float],
        setups: Mapping[str, str] | None = None,
    ) -> None:
        self._component = component
        self._clock = clock
        self._news = news
        self._server_timeout_s = server_timeout_s
        # What feedback an action type has is not part of its description; a type whose goals
        # select a task has, by the convention of the examples, this field.
        self._has_feedback = action_type.has_task_field
        self._controller = Controller[VirtualGoal](
            component, action_type, self, clock, duration, setups=setups
        )
        self._setups: dict[str, str] = {}
        """The words of the state topic about setups, once it says anything."""
        self._setups_told: dict[str, str] | None = None
        """The part of them that the engine knows; None: nothing is published."""
        self._waiting: dict[VirtualGoal, None] = {}
        self._on_the_way: dict[str, VirtualGoal] = {}
        self._in_flight: dict[VirtualGoal, None] = {}
        self._remembered: dict[str, tuple[VirtualGoal, float | None]] = {}
        self._listed: dict[str, str] = {}
        """The status message about the goal that ended; it outlives its result."""
        self._lease: Timer | None = None
        self._value: Any = None
        self._lives = 0
        self._present = False
        """Whether the server is there; `available` lags behind."""
        self.available = False
        self.contest = Contest()
        """The contest of the component."""
        self._controller.switch_on()

    @property
    def server(self) -> str | None:
        """Id of the server that was seen last."""
        return f'{self._component.name}#{self._lives}' if self._lives else None

    def send(self, goal: VirtualGoal) -> None:
        """Request the goal, or wait for the server."""
        if self.available and not self.contest.servers:
            self._on_the_way[goal.request.id] = goal
            goal.timer = self._clock.call_at(self._clock.steady(), lambda: self._deliver(goal))
            return
        self._waiting[goal] = None
        goal.timer = self._after(self._server_timeout_s, lambda: self._give_up(goal))

    def adopt(self, request: GoalRequest) -> VirtualGoal:
        """Return the goal that the server knows, or will know, by this UUID.

        Any other ends LOST.
        """
        if request.id in self._on_the_way:
            return self._on_the_way[request.id]
        self._forget_old()
        known, _ = self._remembered.get(request.id, (None, None))
        if known is not None:
            self._clock.call_at(self._clock.steady(), lambda: self._news.add(known))
            return known
        goal = VirtualGoal(request, self.cancel)
        wait_s = RESULT_CHECK_S if self.available else self._server_timeout_s
        goal.timer = self._after(wait_s, lambda: self.end(goal, self._denial(request.id)))
        return goal

    def cancel(self, goal: VirtualGoal) -> None:
        """Pass a cancel request on, or withdraw a goal that was not sent."""
        if goal.end is not None:
            return
        if goal in self._waiting:
            self._withdraw(goal)
        elif goal.accepted:
            self._clock.call_at(self._clock.steady(), lambda: self._pass_cancel(goal))
        goal.cancel_requested = True

    def bring_in(self, contest: Contest) -> None:
        """Set the contest of the component; an empty one ends it."""
        self.contest = contest
        self._news.add(SeenContest(self._component.name, contest))
        if self.available:
            self._send_waiting()

    def set_up(self, setup: str, value: str) -> None:
        """Let somebody change a setup by hand."""
        self._controller.set_up(setup, value)

    # --- what the controller shows ----------------------------------------------------------

    def appear(self) -> None:
        """Send what waited; goals of the server's earlier life are unknown to it."""
        self._present = self.available = True
        self._lives += 1
        if self._lease is not None:
            self._lease.cancel()
            self._lease = None
        for goal in self._in_flight:
            self._lose_at_check(goal)
        self._send_waiting()

    def vanish(self) -> None:
        """Notice nothing until the lease is over."""
        self._present = False
        self._remembered.clear()
        self._listed.clear()
        self._lease = self._after(SERVER_LEASE_S, self._lease_over)

    def announce(self, ready: bool) -> None:
        """Tell the value of the state topic."""
        state = self._component.state
        if state and self._present:
            self._setups_told = self._setups_told or {}
            self._tell_setups()
            self._tell_state(ready_value(state) if ready else not_ready_value(state))

    def show(self, setup: str, value: Any) -> None:
        """Tell what the state topic says of a setup, once it says anything."""
        self._setups[setup] = self._component.setups[setup].told(value)
        if self._present:
            self._tell_setups()

    def feedback(self, goal: VirtualGoal, done: float) -> None:  # noqa: ARG002 - the port's
        """Keep it with the goal."""
        if self._has_feedback:
            goal.feedback = {'current_sub_task': goal.request.task}

    def end(self, goal: VirtualGoal, end: GoalEnd) -> None:
        """Report the end."""
        goal.stop_timer()
        self._in_flight.pop(goal, None)
        goal.end = end
        if goal.accepted and end.status is not GoalStatus.LOST:
            self._listed = {goal.request.id: end.status.value}
        if goal.request.id in self._remembered:
            del self._remembered[goal.request.id]
            if end.status is not GoalStatus.LOST:
                # Again at the last place: the oldest end comes first.
                self._remembered[goal.request.id] = goal, self._clock.steady()
        self._news.add(goal)

    def note(self, event: str, request: GoalRequest | None = None, **about: Any) -> None:
        """Keep no records: the journal of the run has it all."""

    # --- goals ------------------------------------------------------------------------------

    def _deliver(self, goal: VirtualGoal) -> None:
        goal.timer = None
        self._on_the_way.pop(goal.request.id, None)
        goal.sent_s = self._clock.steady()
        self._in_flight[goal] = None
        if not self._present:
            return
        verdict, why = self._controller.answer(goal.request)
        if verdict is Verdict.ACCEPT:
            self._accept(goal)
            self._controller.start(goal)
        elif verdict is Verdict.REJECT:
            self.end(goal, GoalEnd(GoalStatus.REJECTED, message=why))
        else:
            self._lose_at_check(goal)

    def _accept(self, goal: VirtualGoal) -> None:
        """Tell; cancel what was cancelled before."""
        goal.accepted = True
        self._forget_old()
        self._remembered[goal.request.id] = goal, None
        self._news.add(goal)
        if goal.cancel_requested:
            self.cancel(goal)

    def _pass_cancel(self, goal: VirtualGoal) -> None:
        self._controller.cancel(goal.request.id)

    def _tell_state(self, value: Any) -> None:
        """Tell the value if it changed."""
        if value != self._value:
            self._value = value
            self._news.add(StateReading(self._component.name, value))

    def _tell_setups(self) -> None:
        """Tell those that changed."""
        readings = self._setups_told
        if readings is None:
            return
        for setup, value in self._setups.items():
            if value != readings.get(setup):
                readings[setup] = value
                self._news.add(SetupReading(self._component.name, setup, value))

    def _denial(self, goal_id: str) -> GoalEnd:
        who = self.server if self._present else None
        says = self._listed.get(goal_id, '') if self._present else ''
        return GoalEnd(GoalStatus.LOST, message=_UNKNOWN, denied_by=who, topic_says=says)

    def _send_waiting(self) -> None:
        waiting, self._waiting = self._waiting, {}
        for goal in waiting:
            goal.stop_timer()
            self.send(goal)

    # --- loss -------------------------------------------------------------------------------

    def _lose_at_check(self, goal: VirtualGoal) -> None:
        """End a goal when the server will have said often enough that it does not know it."""
        goal.stop_timer()
        out_ns = instant_ns(self._clock.steady()) - instant_ns(goal.sent_s)
        passed = -(-out_ns // instant_ns(RESULT_CHECK_S))  # rounded up
        checks = max(passed, 1) + (0 if goal.accepted else REQUEST_CHECKS - 1)
        end = GoalEnd(GoalStatus.LOST, message=_UNKNOWN)
        due_s = goal.sent_s + checks * RESULT_CHECK_S
        goal.timer = self._clock.call_at(due_s, lambda: self.end(goal, end))

    def _lease_over(self) -> None:
        self.available = False
        self._lease = None
        for goal in tuple(self._in_flight):
            self.end(goal, GoalEnd(GoalStatus.LOST, message='the server is gone'))
        for setup in self._setups_told or ():
            self._news.add(SetupReading(self._component.name, setup, None))
        self._setups_told = None
        self._tell_state(None)

    def _withdraw(self, goal: VirtualGoal) -> None:
        """End a goal that was not sent now, by a deadline: a settle follows the clock."""
        del self._waiting[goal]
        goal.stop_timer()
        end = GoalEnd(GoalStatus.CANCELED, message=WITHDRAWN, never_begun=True)
        goal.timer = self._clock.call_at(self._clock.steady(), lambda: self.end(goal, end))

    def _give_up(self, goal: VirtualGoal) -> None:
        del self._waiting[goal]
        seconds = f'{self._server_timeout_s:g}'
        message = sentence('no_server', action=self._component.action, seconds=seconds)
        self.end(goal, GoalEnd(GoalStatus.UNAVAILABLE, message=message))

    def _forget_old(self) -> None:
        """Forget what ended so long ago that a server would have (semantics 9.2)."""
        for id_, (_, ended_s) in tuple(self._remembered.items()):
            if ended_s is None:
                continue
            if not has_come(ended_s + self._component.result_timeout_s, self._clock.steady()):
                break
            del self._remembered[id_]

    def _after(self, seconds: float, then: Callable[[], None]) -> Timer:
        return self._clock.call_at(self._clock.steady() + seconds, then)


# One goal in virtual time.


class VirtualGoal:
    """States as in `ports.Goal`, which it implements. Only the gateway's parts change it."""

    __slots__ = (
        '_cancel',
        'accepted',
        'cancel_requested',
        'end',
        'feedback',
        'request',
        'sent_s',
        'timer',
    )

    def __init__(self, request: GoalRequest, cancel: Callable[[VirtualGoal], None]) -> None:
        self.request = request
        self.accepted = False
        self.end: GoalEnd | None = None
        self.feedback: Mapping[str, Any] | None = None
        self.cancel_requested = False
        self.sent_s = 0.0
        """When the request left; the results are asked for again from then on."""
        self.timer: Timer | None = None
        """The next event of it, if nothing else comes."""
        self._cancel = cancel

    def __repr__(self) -> str:
        return f'VirtualGoal({self.request}, accepted={self.accepted}, end={self.end})'

    def cancel(self) -> None:
        """Ask to cancel; see `ports.Goal`."""
        self._cancel(self)

    def stop_timer(self) -> None:
        """Take back what was going to happen next."""
        if self.timer is not None:
            self.timer.cancel()
            self.timer = None
