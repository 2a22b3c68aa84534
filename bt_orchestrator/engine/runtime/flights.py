"""Goals in flight: sending, time limits, and the events of their ends."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

from bt_orchestrator.engine.runtime.goal_ends import TIMEOUT, failed, of_end
from bt_orchestrator.engine.runtime.ledger import Ledger
from bt_orchestrator.engine.runtime.permits import manual, surroundings
from bt_orchestrator.engine.runtime.permits.surroundings import SafetyGuard
from bt_orchestrator.model import effects
from bt_orchestrator.model import events as e
from bt_orchestrator.model.frozen import changed
from bt_orchestrator.model.goal import (
    GoalEnd,
    GoalRequest,
    GoalStatus,
    Reason,
    SafetyReading,
    SeenContest,
    SetupReading,
    StateReading,
)
from bt_orchestrator.model.script import Task, index_task
from bt_orchestrator.model.state import CellState, TaskState
from bt_orchestrator.model.uptime import Uptime, seconds_between
from bt_orchestrator.model.words import sentence
from bt_orchestrator.ports import ActionGateway, Clock, EventStore, Goal, Timer

GRACE_S = 5.0
"""Seconds that a cancelled goal has to reach its terminal status (semantics 2.4)."""

_NEVER_ARRIVED = GoalEnd(
    GoalStatus.CANCELED, message='it never reached its server', never_begun=True
)

_NEVER_SENT = GoalEnd(GoalStatus.UNAVAILABLE, message=_NEVER_ARRIVED.message, never_begun=True)
"""The same of a goal that was not cancelled either, and that is not sent again."""

CARRIED_OUT = {e.OrchestratorStarted, e.TaskStarted, e.TaskResent, e.TaskCancelRequested}
"""Events that ask for goals of an earlier orchestrator, send a goal or cancel one."""


class Flights:
    """All goals of the cell that have not ended."""

    def __init__(
        self,
        ledger: Ledger,
        gateway: ActionGateway,
        clock: Clock,
        wake: Callable[[], None],
        store: EventStore,
    ) -> None:
        """Begin without goals but those of an earlier orchestrator.

        :param store: is asked what it knows of that one
        """
        self._ledger = ledger
        self._gateway = gateway
        self._clock = clock
        self._wake = wake
        self._store = store
        self._goals: dict[str, tuple[e.TaskKey, Goal]] = {}
        self._taken_over = tuple(key for key, task in ledger.state.running.items() if task.goal)
        """Tasks whose goals an earlier orchestrator sent."""
        self._unconfirmed: set[str] = set()
        """Those goals, until their servers have said that they know them (semantics 9.2)."""
        self._given_up: dict[str, tuple[e.TaskKey, Goal]] = {}
        """In doubt: no end came in time, and an operator decides about the task."""
        self._put_off: list[tuple[Goal, GoalEnd]] = []
        """Goals of an earlier orchestrator that may be sent again once no hold stops the line, and
        the component is in service."""
        self._provably_lost: set[str] = set()
        """Those goals among them that provably never arrived."""
        self._safety = SafetyGuard()
        self._unsent: list[Unsent] = []
        self._timers: dict[str, Timer] = {}
        self._expired: list[str] = []

    def goal(self, uuid: str) -> Goal | None:
        """Return a goal in flight."""
        flight = self._goals.get(uuid)
        return flight[1] if flight else None

    @property
    def without_end(self) -> dict[str, tuple[e.TaskKey, Goal]]:
        """Every goal without an end, given up or not, by its UUID."""
        return self._given_up | self._goals

    def close(self) -> None:
        """Forget every time limit; goals in flight stay unchanged."""
        for timer in self._timers.values():
            timer.cancel()
        self._timers.clear()

    def cancel_all(self) -> None:
        """Request the cancel of every goal without an end, off the record."""
        for _, goal in self.without_end.values():
            if goal.end is None:
                goal.cancel()

    # --- before the tick --------------------------------------------------------------------

    def land(self) -> None:
        """Record the gateway's news, and the time limits that have passed."""
        put_off, self._put_off = self._put_off, []
        for goal, end in put_off:
            self._end(goal, end)
        for news in self._gateway.drain():
            if isinstance(news, StateReading):
                self._ledger.record(_of_reading(self._ledger.state, news))
            elif isinstance(news, SetupReading):
                self._ledger.record([e.ComponentSetupRead(**vars(news))])
            elif isinstance(news, SeenContest):
                self._ledger.record(surroundings.seen(self._ledger.state, news))
            elif isinstance(news, SafetyReading):
                self._ledger.record(self._safety.seen(self._ledger.state, news))
            else:
                if self._unconfirmed:
                    self._confirm(news)
                if news.end is not None:
                    self._end(news, news.end)
        unsent, self._unsent = self._unsent, []
        for goal in unsent:  # behind the loss, which cancels it
            self._end(goal, goal.end)
        expired, self._expired = self._expired, []
        for uuid in expired:
            self._expire(uuid)

    def _confirm(self, goal: Goal) -> None:
        """Record that a goal of an earlier orchestrator was found at its server."""
        uuid = goal.request.id
        key, held = self._goals.get(uuid, (None, None))
        if uuid not in self._unconfirmed or not goal.accepted or key is None or held is not goal:
            return
        self._unconfirmed.remove(uuid)
        attempt = self._ledger.state.running[key].attempt
        self._ledger.record([e.TaskAdopted(**key._asdict(), attempt=attempt, goal=uuid)])

    def _end(self, goal: Goal, end: GoalEnd) -> None:
        uuid = goal.request.id
        self._given_up.pop(uuid, None)
        key, held = self._goals.get(uuid, (None, None))
        if key is None or held is not goal:
            return  # given up before (its operator decides), or sent again since
        timer = self._timers.pop(uuid, None)
        if timer is not None:
            timer.cancel()
        if self._must_wait(key, goal, end):
            self._put_off.append((goal, end))
            return
        del self._goals[uuid]
        state = self._ledger.state
        was_unknown = uuid in self._unconfirmed and end.status is GoalStatus.LOST
        self._unconfirmed.discard(uuid)
        event = self._of_unknown(key, goal, end) if was_unknown else of_end(state, key, goal, end)
        self._ledger.record([event])
        if isinstance(event, e.TaskSucceeded):
            self._ledger.record(effects.of_success(state, key))
        elif key == e.MANUAL_KEY:
            self._ledger.record(manual.held(state))

    def _must_wait(self, key: e.TaskKey, goal: Goal, end: GoalEnd) -> bool:
        """Tell whether a goal is to be sent again, but an operator must allow it first.

        The line has to be checked, or the component is out of service.
        """
        if goal.request.id not in self._unconfirmed or end.status is not GoalStatus.LOST:
            return False
        state = self._ledger.state
        is_blocked = bool(state.stops) or self._task(key).component in state.out_of_service
        return self._may_go_again(key, end) and is_blocked

    def _expire(self, uuid: str) -> None:
        if uuid not in self._goals:
            return
        key, goal = self._goals[uuid]
        task = self._ledger.state.running[key]
        if task.cancel_cause is None:
            asked = e.TaskCancelRequested(**key._asdict(), goal=uuid, cause=TIMEOUT)
            self._ledger.record([asked])
            return
        self._given_up[uuid] = self._goals.pop(uuid)
        message = sentence('no_end', seconds=f'{GRACE_S:g}', cause=task.cancel_cause)
        self._ledger.record([failed(self._ledger.state, key, goal, Reason.IN_DOUBT, message)])
        if key == e.MANUAL_KEY:
            self._ledger.record(manual.held(self._ledger.state))

    def _of_unknown(self, key: e.TaskKey, goal: Goal, end: GoalEnd) -> e.TaskEvent:
        """Return the event for a goal of an earlier orchestrator that its server denies (9.2)."""
        running, task = self._ledger.state.running[key], self._task(key)
        assert running.goal is not None
        if running.cancel_cause is not None and self._is_proven(key, end):
            ended = of_end(self._ledger.state, key, goal, _NEVER_ARRIVED)
            return changed(ended, never_begun=True)
        if key == e.MANUAL_KEY and self._is_proven(key, end):
            ended = of_end(self._ledger.state, key, goal, _NEVER_SENT)
            return changed(ended, never_begun=True)
        if self._may_go_again(key, end):
            return e.TaskResent(
                **key._asdict(),
                attempt=running.attempt,
                goal=running.goal,
                server=self._ledger.server(task.component),
                uptime=self._ledger.uptime,
            )
        may_live = self._store.epoch and running.sent_up and not self._is_of_this_boot(running)
        kind = 'after_take_over' if may_live else 'after_restart'
        message = sentence(kind, words=end.message)
        return failed(self._ledger.state, key, goal, Reason.IN_DOUBT, message)

    def _may_go_again(self, key: e.TaskKey, end: GoalEnd) -> bool:
        running, task = self._ledger.state.running[key], self._task(key)
        assert running.goal is not None
        if running.cancel_cause is not None or running.copied or key == e.MANUAL_KEY:
            return False  # in manual mode nothing starts by itself (7.11)
        return self._is_proven(key, end) or task.repeatable

    def _is_proven(self, key: e.TaskKey, end: GoalEnd) -> bool:
        """Tell whether it is proven that a goal never reached its server (semantics 9.2).

        The same server instance that it was sent to does not know it, at a time when it would
        still remember even a goal that had ended at once. The steady clock proves that time. The
        wall clock has to agree, because servers forget by theirs. A status topic that lists the
        goal disproves it: the server forgets sooner than the cell file says.

        A node on another machine counts from the last moment at which it did not see the goal in
        the journal (semantics 9.4): the goal was sent after that.
        """
        running, component = self._ledger.state.running[key], self._task(key).component
        assert running.goal is not None
        if running.goal in self._provably_lost:
            return True  # and it does not arrive while the line is checked
        remembered_s = self._ledger.state.cell.components[component].result_timeout_s
        if end.topic_says or running.copied:
            return False
        is_same = end.denied_by is not None and end.denied_by == running.server
        if is_same and (
            self._is_within(remembered_s, running.sent_up, running.sent)
            or self._was_absent_within(remembered_s, running)
        ):
            self._provably_lost.add(running.goal)
        return running.goal in self._provably_lost

    def _is_of_this_boot(self, running: TaskState) -> bool:
        return seconds_between(running.sent_up, self._clock.uptime()) is not None

    def _was_absent_within(self, seconds: float, running: TaskState) -> bool:
        """Tell whether this machine has seen a goal's absence from the journal so lately."""
        if running.cancel_cause is not None:
            return False
        absent = self._store.absent_at(running.sent_seq)
        return absent is not None and self._is_within(seconds, absent.up, absent.wall)

    def _is_within(self, seconds: float, up: Uptime | None, wall: float) -> bool:
        """Tell whether less time has passed since a moment, by both clocks."""
        passed = (seconds_between(up, self._clock.uptime()), self._ledger.now - wall)
        return all(s is not None and 0.0 <= s < seconds for s in passed)

    # --- during the commit ------------------------------------------------------------------

    def prepare(self, events: Iterable[e.Event]) -> None:
        """Let the gateway prepare the goals that are sent once these events are durable."""
        for event in events:
            if isinstance(event, e.TaskStarted):
                self._gateway.prepare(_request_of(event))

    # --- after the commit -------------------------------------------------------------------

    def follow(self, event: e.Event) -> None:
        """Carry out a durable event of `CARRIED_OUT`: send a goal, or cancel one."""
        if isinstance(event, e.TaskStarted):
            self._send(event, _request_of(event))
        elif isinstance(event, e.OrchestratorStarted):
            for key in self._taken_over:
                self._adopt(key)
        elif isinstance(event, e.TaskResent):
            self._send(event, self._request(event.key))
        elif isinstance(event, e.TaskCancelRequested) and event.goal in self._goals:
            self._goals[event.goal][1].cancel()
            self._arm(event.goal, GRACE_S)

    def _send(self, event: e.TaskStarted | e.TaskResent, request: GoalRequest) -> None:
        """Send a goal, unless the safety input was lost while its record was written (7.9)."""
        if self._gateway.unsafe:
            unsent = Unsent(request)
            self._goals[event.goal] = (event.key, unsent)
            self._unsent.append(unsent)
            self._wake()
            return
        self._goals[event.goal] = (event.key, self._gateway.send(request))
        self._watch(event.key)

    def _adopt(self, key: e.TaskKey) -> None:
        """Ask for the goal of an earlier orchestrator; nothing is sent."""
        request = self._request(key)
        goal = self._gateway.adopt(request)
        self._goals[request.id] = (key, goal)
        self._unconfirmed.add(request.id)
        if self._ledger.state.running[key].cancel_cause is not None:
            goal.cancel()
        self._watch(key)

    def _request(self, key: e.TaskKey) -> GoalRequest:
        """Return the request of a task that runs, as it was sent."""
        running = self._ledger.state.running[key]
        assert running.goal is not None
        task = self._task(key)
        return GoalRequest(running.goal, task.component, task.name, running.args)

    def _task(self, key: e.TaskKey) -> Task:
        return self._ledger.state.task(key) or index_task(self._ledger.state.cell)

    def _watch(self, key: e.TaskKey) -> None:
        """Arm the time limit of a goal in flight, or the grace time of a cancelled one.

        If the goal was sent before a boot, or from another machine, its age is unknown: its time
        begins anew.
        """
        running = self._ledger.state.tasks[key]
        timeout_s = self._task(key).timeout_s
        if running.goal is None:
            return
        if running.cancel_cause is not None:
            self._arm(running.goal, GRACE_S)
        elif timeout_s is not None:
            ago_s = seconds_between(running.sent_up, self._clock.uptime()) or 0.0
            self._arm(running.goal, timeout_s - ago_s)

    def _arm(self, uuid: str, seconds: float) -> None:
        before = self._timers.pop(uuid, None)
        if before is not None:
            before.cancel()
        due = self._clock.steady() + seconds
        self._timers[uuid] = self._clock.call_at(due, lambda: self._note(uuid))

    def _note(self, uuid: str) -> None:
        self._timers.pop(uuid, None)
        self._expired.append(uuid)
        self._wake()


class Unsent:
    """A goal that is not sent, because the safety input was lost while it was put on record.

    Implements `ports.Goal`.
    """

    accepted = False
    feedback = None

    def __init__(self, request: GoalRequest) -> None:
        self.request = request
        self.end = GoalEnd(
            GoalStatus.CANCELED, message=sentence('unsafe_unsent'), never_begun=True
        )

    def cancel(self) -> None:
        """Do nothing: it has ended."""


def _request_of(event: e.TaskStarted) -> GoalRequest:
    return GoalRequest(event.goal, event.component, event.name, event.args)


def _of_reading(state: CellState, reading: StateReading) -> Iterator[e.Event]:
    topic = state.cell.components[reading.component].state
    ready = topic is not None and reading.value in topic.ready
    yield e.ComponentStateChanged(component=reading.component, ready=ready, value=reading.value)
