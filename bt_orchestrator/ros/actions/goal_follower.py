"""Answers, status and results of goals that were sent."""

from __future__ import annotations

import time
import uuid
from functools import partial
from typing import Any

from action_msgs.msg import GoalStatus as WireStatus

from bt_orchestrator.model.goal import REQUEST_CHECKS, RESULT_CHECK_S, GoalStatus
from bt_orchestrator.model.words import sentence
from bt_orchestrator.ports.spare_log import Logger, report
from bt_orchestrator.ros.actions.fresh_participant import RenewableClient
from bt_orchestrator.ros.actions.goal_client import GoalClient
from bt_orchestrator.ros.actions.open_goals import GIVEN_UP, Leave, OpenGoals, RosGoal
from bt_orchestrator.ros.actions.rivals import Rivals
from bt_orchestrator.ros.types.messages import to_plain

_ENDS = {
    WireStatus.STATUS_SUCCEEDED: GoalStatus.SUCCEEDED,
    WireStatus.STATUS_ABORTED: GoalStatus.ABORTED,
    WireStatus.STATUS_CANCELED: GoalStatus.CANCELED,
}

_SAID = {
    WireStatus.STATUS_SUCCEEDED: 'succeeded',
    WireStatus.STATUS_CANCELED: 'canceled',
    WireStatus.STATUS_ABORTED: 'aborted',
}


class GoalFollower:
    """Hears of goals by answer, status and result, and asks for the result by UUID.

    Whatever comes for a goal that has ended is dropped; a late yes to a request is cancelled, so
    that no goal is orphaned (semantics 2.4).
    """

    def __init__(
        self,
        clients: RenewableClient,
        goals: OpenGoals,
        rivals: Rivals,
        logger: Logger,
        leave: Leave,
    ) -> None:
        self._clients = clients
        self._goals = goals
        self._rivals = rivals
        self._logger = logger
        self._leave = leave

    @property
    def _client(self) -> GoalClient:
        return self._clients.current

    def ask(self, goal: RosGoal, *, is_check: bool) -> None:
        """Ask for the result.

        :param is_check: whether the server must know the goal by now; the question that follows
            an acceptance at once may overtake the server's own book-keeping
        """
        self._client.ask_result(
            goal.id, partial(self._on_result, goal, is_check, time.monotonic())
        )

    def repeat_cancel(self, goal: RosGoal) -> None:
        """Cancel a goal by its UUID, since its acceptance may never come."""
        if goal.cancel_requested:
            self._client.request_cancel(goal.id)

    def listed_end(self, goal: RosGoal) -> str:
        """Return the end of a goal without a result by the status topic; empty: it has none."""
        return _SAID.get(self._client.status.of(goal.id), '')

    def look_at_status(self, goal: RosGoal) -> None:
        """Learn from the server's status topic that it has the goal; the answer may be lost."""
        status = self._client.status
        if not goal.listed and status.of(goal.id) is not None:
            goal.listed = True
            if not goal.adopted or status.is_active(goal.id):
                self._on_accepted(goal)

    # --- what comes -------------------------------------------------------------------------

    def on_response(self, goal: RosGoal, response: Any) -> None:
        """Take the answer to the request."""
        try:
            accepted = bool(response.accepted)
            if goal.end is not None:
                self._on_late_response(goal, accepted)
            elif not accepted:
                # It may have this UUID already: then it is no rejection (semantics 9.2).
                goal.refused = True
                self.ask(goal, is_check=True)
            else:
                self._on_accepted(goal)
        except Exception as error:  # noqa: BLE001 - whatever it is, the other goals go on
            self._on_failure(goal, error)

    def _on_accepted(self, goal: RosGoal) -> None:
        if goal.accepted or goal.end is not None:
            return
        self._goals.accept(goal)
        self.ask(goal, is_check=False)
        self.repeat_cancel(goal)

    def _on_late_response(self, goal: RosGoal, accepted: bool) -> None:
        self._goals.answered_late(goal)
        if accepted and goal.end is not None and goal.end.status in GIVEN_UP:
            text = f'goal {goal.request.id} was accepted after it was given up; it is cancelled'
            self._logger.warning(text)
            self._client.request_cancel(goal.id)

    def _on_result(self, goal: RosGoal, is_check: bool, asked_s: float, response: Any) -> None:
        if goal.end is not None:
            return
        try:
            status = response.status
            if status in _ENDS:
                goal.accepted = True
                self._goals.end(goal, _ENDS[status], result=to_plain(response.result))
            elif status == WireStatus.STATUS_UNKNOWN and is_check:
                self._on_unknown(goal, asked_s)
        except Exception as error:  # noqa: BLE001 - as above
            self._on_failure(goal, error)

    def _on_unknown(self, goal: RosGoal, asked_s: float) -> None:
        goal.heard_s = time.monotonic()
        if self._rivals.seen_within(RESULT_CHECK_S):
            return  # another server than the one that has it may have said so
        goal.unknown_count += 1
        believed = 1 if goal.accepted else REQUEST_CHECKS
        if goal.refused:
            message = '; '.join([sentence('refused'), *self._busy_with()])
            self._goals.end(goal, GoalStatus.REJECTED, message=message)
        elif goal.unknown_count >= believed and self._leave.is_alone(goal, asked_s):
            self._goals.end(
                goal,
                GoalStatus.LOST,
                message=sentence('not_known'),
                denied_by=self._denier(goal),
                topic_says=self.listed_end(goal),
            )
        else:
            goal.denied_by = self._client.status.publisher_id()

    def _busy_with(self) -> list[str]:
        """Name a running goal of another client, if there is one."""
        goals = (goal for goal in self._client.status.active() if not self._goals.is_ours(goal))
        foreign = next(goals, None)
        if foreign is None:
            return []
        return [sentence('others_goal', goal=uuid.UUID(bytes=foreign))]

    def _denier(self, goal: RosGoal) -> str | None:
        """Return which server does not know a goal, if it was there at both answers."""
        there = self._client.status.publisher_id()
        return there if there == goal.denied_by else None

    def _on_failure(self, goal: RosGoal, error: Exception) -> None:
        """End a goal after a message that cannot be handled: its real end is not known."""
        report(self._logger)
        if goal.end is None:
            message = f'error while handling the answer of the server: {error}'
            self._goals.end(goal, GoalStatus.LOST, message=message)
