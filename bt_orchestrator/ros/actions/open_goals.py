"""The goals that a link has open at a real action server, and how they end."""

from __future__ import annotations

import uuid
from collections import deque
from collections.abc import Callable, Mapping
from typing import Any, Protocol

from unique_identifier_msgs.msg import UUID

from bt_orchestrator.model.goal import GoalEnd, GoalRequest, GoalStatus
from bt_orchestrator.ports.news import News
from bt_orchestrator.ros.actions.fresh_participant import RenewableClient
from bt_orchestrator.ros.executor.ways import Question

GIVEN_UP = (GoalStatus.LOST, GoalStatus.SILENT)
"""Ends after which the server may still say yes to the request."""

_MOST_UNANSWERED = 16
"""Requests given up whose late answer is still listened to."""


_OURS_KEPT = 64
"""Remembered ids of goals: more than the number of our goals that a server could still run."""


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
        self._unanswered: list[Question] = []
        self._ours: deque[bytes] = deque(maxlen=_OURS_KEPT)
        self.waiting: dict[RosGoal, float] = {}
        self.in_flight: dict[RosGoal, None] = {}

    @property
    def any_sent(self) -> bool:
        """Tell whether something may still come: of a goal in flight, or a late answer."""
        return bool(self.in_flight or self._unanswered)

    def begin(self, goal: RosGoal) -> None:
        """Note that a goal is at the server, or on its way."""
        self.in_flight[goal] = None
        self._ours.append(bytes(goal.id.uuid))

    def is_ours(self, goal_id: bytes) -> bool:
        """Tell whether a goal was sent, or taken over, by this process."""
        return goal_id in self._ours

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
        topic_says: str = '',
    ) -> None:
        """End a goal; arguments as in `GoalEnd`."""
        self.end_with(goal, GoalEnd(status, result or {}, message, denied_by, topic_says))

    def end_with(self, goal: RosGoal, end: GoalEnd) -> None:
        """End a goal and free what its client keeps."""
        self.waiting.pop(goal, None)
        self.in_flight.pop(goal, None)
        self._clients.forget(goal.id)
        if goal.question is not None and goal.question.is_open:
            if end.status in GIVEN_UP:
                self._remember_unanswered(goal.question)
            else:  # an answer that was lost on its way
                goal.question.drop()
        goal.end = end
        self._news.add(goal)

    def answered_late(self, goal: RosGoal) -> None:
        """Take note of the answer to the request of a goal that has ended."""
        if goal.question in self._unanswered:
            self._unanswered.remove(goal.question)

    def forget_unanswered(self) -> None:
        """Stop listening for late answers: the server that would send them is gone."""
        for question in self._unanswered:
            question.drop()
        self._unanswered.clear()

    def _remember_unanswered(self, question: Question) -> None:
        self._unanswered.append(question)
        if len(self._unanswered) > _MOST_UNANSWERED:
            self._unanswered.pop(0).drop()


# One goal at a real action server.


class Link(Protocol):
    """The part of an `ActionLink` that a goal needs."""

    def cancel(self, goal: RosGoal) -> None:
        """Pass a cancel request on."""

    def feedback(self, goal: RosGoal) -> Mapping[str, Any] | None:
        """Return the last feedback."""


class RosGoal:
    """States as in `ports.Goal`, which it implements. Only parts of its `ActionLink` change it."""

    __slots__ = (
        '_link',
        'accepted',
        'adopted',
        'cancel_requested',
        'denied_by',
        'end',
        'heard_s',
        'id',
        'listed',
        'message',
        'next_check_s',
        'question',
        'refused',
        'renewed',
        'request',
        'unknown_count',
    )

    def __init__(self, request: GoalRequest, link: Link) -> None:
        self.request = request
        self.accepted = False
        self.end: GoalEnd | None = None
        self.id = UUID(uuid=list(uuid.UUID(request.id).bytes))
        self.adopted = False
        """True for a goal of an earlier process, which is asked for and never sent."""
        self.cancel_requested = False
        self.refused = False
        """True once the server said no, and is asked whether it has the UUID already."""
        self.message: Any = None
        """The request's goal message, if it was made ahead."""
        self.question: Question | None = None
        """The request; None: nothing was sent."""
        self.listed = False
        """True once the server's status topic listed it."""
        self.next_check_s = 0.0
        """When its result is asked for again, on the steady clock."""
        self.heard_s = 0.0
        """Until when the server may be silent, on the steady clock."""
        self.renewed = False
        """True once a fresh participant has asked about it, after the first one got no answer."""
        self.unknown_count = 0
        """How often the server did not know it."""
        self.denied_by: str | None = None
        """Instance of the server that was there when it did not."""
        self._link = link

    @property
    def feedback(self) -> Mapping[str, Any] | None:
        """The last feedback; read when somebody looks, as servers may send a lot of it."""
        return self._link.feedback(self)

    def __repr__(self) -> str:
        return f'RosGoal({self.request}, accepted={self.accepted}, end={self.end})'

    def cancel(self) -> None:
        """Ask the server to cancel; see `ports.Goal`."""
        self._link.cancel(self)


# The right of this node to send goals.


class Leave:
    """Whether goals may be sent, and since when no other node does (semantics 9.4)."""

    def __init__(self) -> None:
        """Begin with a node that is alone."""
        self.may_send: Callable[[], bool] = _always
        self.alone_from_s = 0.0
        """By the monotonic clock."""

    def is_alone(self, goal: RosGoal, asked_s: float) -> bool:
        """Tell whether the answer to a question about a goal is final.

        An earlier leader may still have sent a goal of its own after an earlier question.
        """
        return not goal.adopted or asked_s >= self.alone_from_s


def _always() -> bool:
    """Stand for the right of a node whose journal no other one can have."""
    return True
