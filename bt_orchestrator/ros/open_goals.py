"""The goals that a link has open, and how they end."""

from __future__ import annotations

from typing import Any

from bt_orchestrator.model.goal import GoalEnd, GoalStatus
from bt_orchestrator.news import News
from bt_orchestrator.ros.goal import RosGoal
from bt_orchestrator.ros.renewable_client import RenewableClient

GIVEN_UP = (GoalStatus.LOST, GoalStatus.SILENT)
"""Ends after which the server may still say yes to the request."""

_MOST_UNANSWERED = 16
"""Requests given up whose late answer is still listened to."""


class OpenGoals:
    """A goal is waiting (for the server), then in flight, then ended and not known here any more.

    :ivar waiting: until when each may wait, on the steady clock
    :ivar in_flight: an ordered set
    """

    def __init__(self, clients: RenewableClient, news: News) -> None:
        """Begin without any.

        :param news: gets each goal that is accepted, and that ends
        """
        self._clients = clients
        self._news = news
        self._unanswered: list[Any] = []
        self.waiting: dict[RosGoal, float] = {}
        self.in_flight: dict[RosGoal, None] = {}

    @property
    def any_sent(self) -> bool:
        """Tell whether something may still come: of a goal in flight, or a late answer."""
        return bool(self.in_flight or self._unanswered)

    def accept(self, goal: RosGoal) -> None:
        """Note that the server has taken a goal."""
        goal.accepted = True
        self._news.add(goal)

    def end(
        self,
        goal: RosGoal,
        status: GoalStatus,
        *,
        result: Any = None,
        message: str = '',
        denied_by: str | None = None,
    ) -> None:
        """End a goal and free what its client keeps; arguments as in `GoalEnd`."""
        self.waiting.pop(goal, None)
        self.in_flight.pop(goal, None)
        self._clients.forget(goal.id)
        if goal.response is not None and not goal.response.done():
            if status in GIVEN_UP:
                self._remember_unanswered(goal.response)
            else:  # an answer that was lost on its way
                self._clients.forget_request(goal.response)
        goal.end = GoalEnd(status, result or {}, message, denied_by)
        self._news.add(goal)

    def answered_late(self, response: Any) -> None:
        """Take note of the answer to the request of a goal that has ended."""
        if response in self._unanswered:
            self._unanswered.remove(response)

    def forget_unanswered(self) -> None:
        """Listen to no late answer any more: whoever would give it is gone."""
        for response in self._unanswered:
            self._clients.forget_request(response)
        self._unanswered.clear()

    def _remember_unanswered(self, response: Any) -> None:
        self._unanswered.append(response)
        if len(self._unanswered) > _MOST_UNANSWERED:
            self._clients.forget_request(self._unanswered.pop(0))
