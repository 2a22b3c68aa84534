"""Watches goals in flight: result requests again, silent servers, and lost servers."""

from __future__ import annotations

import time

from bt_orchestrator.model.goal import RESULT_CHECK_S, SILENCE_S, GoalStatus
from bt_orchestrator.model.words import sentence
from bt_orchestrator.ports.spare_log import Logger
from bt_orchestrator.ros.actions.fresh_participant import RenewableClient
from bt_orchestrator.ros.actions.goal_client import GoalClient
from bt_orchestrator.ros.actions.goal_follower import GoalFollower
from bt_orchestrator.ros.actions.open_goals import OpenGoals, RosGoal
from bt_orchestrator.ros.actions.rivals import Rivals


class ServerWatch:
    """Looks after the goals in flight at one server (semantics 9.3)."""

    def __init__(
        self,
        action: str,
        clients: RenewableClient,
        goals: OpenGoals,
        follower: GoalFollower,
        rivals: Rivals,
        logger: Logger,
    ) -> None:
        """Watch the server of an action.

        :param action: its name, for messages
        """
        self._action = action
        self._clients = clients
        self._goals = goals
        self._follower = follower
        self._rivals = rivals
        self._logger = logger
        self._seen_missing = False

    @property
    def _client(self) -> GoalClient:
        return self._clients.current

    def begin(self, goal: RosGoal) -> None:
        """Look after a goal that was just sent, or asked for, until it ends."""
        goal.heard_s = time.monotonic()
        goal.next_check_s = goal.heard_s + RESULT_CHECK_S
        self._goals.begin(goal)

    def look(self) -> None:
        """Do what is due; to be called a few times a second."""
        if not self._goals.any_sent:
            self._seen_missing = False
        elif self._client.server_is_there():
            self._seen_missing = False
            for goal in [goal for goal in self._goals.in_flight if not goal.accepted]:
                self._follower.look_at_status(goal)
            self._check()
        elif self._clients.is_looking:
            pass
        elif self._seen_missing:
            self._lose_server()
        else:
            # Once more, since a graph that is in motion may say so for a moment.
            self._seen_missing = True

    def _check(self) -> None:
        now = time.monotonic()
        for goal in [goal for goal in self._goals.in_flight if goal.next_check_s <= now]:
            goal.next_check_s += RESULT_CHECK_S
            self._follower.look_at_status(goal)
            if self._may_be_silent(goal):
                goal.heard_s = now
            elif now - goal.heard_s >= SILENCE_S and goal.renewed:
                self._give_up(goal)
                continue
            elif now - goal.heard_s >= SILENCE_S:
                self._renew()
            if not goal.accepted or goal.renewed:
                self._follower.repeat_cancel(goal)
            self._follower.ask(goal, is_check=True)

    def _may_be_silent(self, goal: RosGoal) -> bool:
        """Tell whether a server may leave a question about a goal open (semantics 9.3).

        It may while its status says of any goal that it runs, if it accepted this one and has no
        status, and while there are several servers: then nobody knows whose silence it is.
        """
        if self._client.status.is_busy or self._rivals.look():
            return True
        return goal.accepted and not goal.listed

    def _renew(self) -> None:
        text = f'{self._action} does not answer; it is asked through a fresh participant'
        self._logger.warning(text)
        if self._clients.may_be_renewed:
            self._clients.renew()
        now = time.monotonic()
        for goal in self._goals.in_flight:
            goal.renewed = True
            goal.heard_s = now

    def _give_up(self, goal: RosGoal) -> None:
        message = sentence('silent', action=self._action)
        says = self._follower.listed_end(goal)
        self._goals.end(goal, GoalStatus.SILENT, message=message, topic_says=says)

    def _lose_server(self) -> None:
        message = sentence('gone', action=self._action)
        for goal in tuple(self._goals.in_flight):
            self._goals.end(goal, GoalStatus.LOST, message=message)
        self._goals.forget_unanswered()
