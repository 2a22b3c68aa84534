"""Goals in flight: sent, watched for their time limits, and turned into events when they end."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from bt_orchestrator.model import effects
from bt_orchestrator.model import events as e
from bt_orchestrator.model.action_type import TASK_RESULT
from bt_orchestrator.model.goal import GoalEnd, GoalRequest, GoalStatus, Reason, StateReading
from bt_orchestrator.model.state import CellState, TaskState
from bt_orchestrator.ports import ActionGateway, Clock, Goal, Timer
from bt_orchestrator.runtime.ledger import Ledger
from bt_orchestrator.tree.belt import index_task

GRACE_S = 5.0
"""Seconds that a cancelled goal has to reach its terminal status (semantics 2.4)."""

TIMEOUT = 'timeout'

_REASONS = {
    GoalStatus.ABORTED: Reason.ABORTED,
    GoalStatus.CANCELED: Reason.CANCELED,
    GoalStatus.REJECTED: Reason.GOAL_REJECTED,
    GoalStatus.UNAVAILABLE: Reason.SERVER_UNAVAILABLE,
    GoalStatus.LOST: Reason.SERVER_LOST,
}


class Flights:
    """All goals of the cell that have not ended."""

    def __init__(
        self, ledger: Ledger, gateway: ActionGateway, clock: Clock, wake: Callable[[], None]
    ) -> None:
        self._ledger = ledger
        self._gateway = gateway
        self._clock = clock
        self._wake = wake
        self._goals: dict[str, tuple[e.TaskKey, Goal]] = {}
        self._timers: dict[str, Timer] = {}
        self._expired: list[str] = []

    def goal(self, uuid: str) -> Goal | None:
        """Return a goal in flight."""
        found = self._goals.get(uuid)
        return found[1] if found else None

    # --- before the tick --------------------------------------------------------------------

    def land(self) -> None:
        """Record what the gateway has to tell, and the time limits that have passed."""
        for news in self._gateway.drain():
            if isinstance(news, StateReading):
                self._ledger.record(_of_reading(self._ledger.state, news))
            elif news.end is not None:
                self._end(news, news.end)
        expired, self._expired = self._expired, []
        for uuid in expired:
            self._expire(uuid)

    def _end(self, goal: Goal, end: GoalEnd) -> None:
        key, _ = self._goals.pop(goal.request.id, (None, None))
        timer = self._timers.pop(goal.request.id, None)
        if timer is not None:
            timer.cancel()
        if key is None:
            return  # given up before: it was held as in_doubt, and its operator decides
        state = self._ledger.state
        event = _of_end(key, state.running[key], end)
        self._ledger.record([event])
        if isinstance(event, e.TaskSucceeded):
            self._ledger.record(effects.of_success(state, key))

    def _expire(self, uuid: str) -> None:
        if uuid not in self._goals:
            return
        key, goal = self._goals[uuid]
        task = self._ledger.state.running[key]
        if task.cancel_cause is None:
            asked = e.TaskCancelRequested(**key._asdict(), goal=uuid, cause=TIMEOUT)
            self._ledger.record([asked])
            return
        del self._goals[uuid]
        message = f'no end came within {GRACE_S:g} s of the cancel request ({task.cancel_cause})'
        doubt = e.TaskFailed(
            **key._asdict(),
            attempt=task.attempt,
            goal=goal.request.id,
            reason=Reason.IN_DOUBT.value,
            message=message,
        )
        self._ledger.record([doubt])

    # --- after the commit -------------------------------------------------------------------

    def follow(self, event: e.Event) -> None:
        """Do what a durable event asks for: send a goal, or cancel one."""
        if isinstance(event, e.TaskStarted):
            self._send(event)
        elif isinstance(event, e.TaskCancelRequested) and event.goal in self._goals:
            self._goals[event.goal][1].cancel()
            self._arm(event.goal, event.time + GRACE_S)

    def _send(self, event: e.TaskStarted) -> None:
        request = GoalRequest(event.goal, event.component, event.name, event.args)
        self._goals[event.goal] = (event.key, self._gateway.send(request))
        task = self._ledger.state.task(event.key) or index_task(self._ledger.state)
        if task.timeout_s is not None:
            self._arm(event.goal, event.time + task.timeout_s)

    def _arm(self, uuid: str, time: float) -> None:
        before = self._timers.pop(uuid, None)
        if before is not None:
            before.cancel()
        self._timers[uuid] = self._clock.call_at(time, lambda: self._note(uuid))

    def _note(self, uuid: str) -> None:
        self._timers.pop(uuid, None)
        self._expired.append(uuid)
        self._wake()


def _of_reading(state: CellState, reading: StateReading) -> Iterator[e.Event]:
    topic = state.cell.components[reading.component].state
    ready = topic is not None and reading.value in topic.ready
    yield e.ComponentStateChanged(component=reading.component, ready=ready, value=reading.value)


def _of_end(key: e.TaskKey, task: TaskState, end: GoalEnd) -> e.TaskEvent:
    """Return what the end of a goal means for its task (semantics 2.2, 2.3)."""
    assert task.goal is not None
    results = {name: value for name, value in end.result.items() if name != TASK_RESULT}
    if end.status is GoalStatus.SUCCEEDED and end.result.get(TASK_RESULT, True) is not False:
        return e.TaskSucceeded(
            **key._asdict(), attempt=task.attempt, goal=task.goal, results=results
        )
    return e.TaskFailed(
        **key._asdict(),
        attempt=task.attempt,
        goal=task.goal,
        reason=_reason(task, end).value,
        message=end.message,
    )


def _reason(task: TaskState, end: GoalEnd) -> Reason:
    if end.status is GoalStatus.SUCCEEDED:
        return Reason.TASK_RESULT_FALSE
    if task.cancel_cause == TIMEOUT and end.status in (GoalStatus.CANCELED, GoalStatus.ABORTED):
        return Reason.TIMEOUT
    return _REASONS[end.status]
