"""One goal at a real action server."""

from __future__ import annotations

import uuid
from collections.abc import Mapping
from typing import Any, Protocol

from unique_identifier_msgs.msg import UUID

from bt_orchestrator.model.goal import GoalEnd, GoalRequest
from bt_orchestrator.ros.actions.questions import Question


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
