"""One goal at a real action server."""

from __future__ import annotations

import uuid
from collections.abc import Callable
from typing import Any

from unique_identifier_msgs.msg import UUID

from bt_orchestrator.model.goal import Feedback, GoalEnd, GoalRequest
from bt_orchestrator.ros.messages import to_plain


class RosGoal:
    """States as in `ports.Goal`, which it implements. Only parts of its `ActionLink` change it."""

    __slots__ = (
        '_cancel',
        '_feedback',
        '_feedback_message',
        'accepted',
        'adopted',
        'cancel_requested',
        'denied_by',
        'end',
        'heard_s',
        'id',
        'listed',
        'next_check_s',
        'refused',
        'renewed',
        'request',
        'response',
        'unknown_count',
    )

    def __init__(self, request: GoalRequest, cancel: Callable[[RosGoal], None]) -> None:
        self.request = request
        self.accepted = False
        self.end: GoalEnd | None = None
        self.id = UUID(uuid=list(uuid.UUID(request.id).bytes))
        self.adopted = False
        """True for a goal of an earlier process, which is asked for and never sent."""
        self.cancel_requested = False
        self.refused = False
        """True once the server said no, and is asked whether it has the UUID already."""
        self.response: Any = None
        """Future of the server's answer to the request."""
        self.listed = False
        """True once the server's status topic listed it."""
        self.next_check_s = 0.0
        """When its result is asked for again, on the steady clock."""
        self.heard_s = 0.0
        """Until when there is no reason to wonder at the server's silence, on the steady clock."""
        self.renewed = False
        """True once it was asked about in a fresh way, because the old one stayed silent."""
        self.unknown_count = 0
        """How often the server did not know it."""
        self.denied_by: str | None = None
        """Instance of the server that was there when it did not."""
        self._cancel = cancel
        self._feedback: Feedback | None = None
        self._feedback_message: tuple[float, Any] | None = None

    @property
    def feedback(self) -> Feedback | None:
        """The last feedback; converted when somebody looks, as servers may send a lot of it."""
        if self._feedback_message is not None:
            time, message = self._feedback_message
            self._feedback = Feedback(time, to_plain(message))
            self._feedback_message = None
        return self._feedback

    def keep_feedback(self, time: float, message: Any) -> None:
        """Replace the last feedback.

        :param time: seconds, of the gateway's clock
        """
        self._feedback_message = (time, message)

    def __repr__(self) -> str:
        return f'RosGoal({self.request}, accepted={self.accepted}, end={self.end})'

    def cancel(self) -> None:
        """Ask the server to cancel; see `ports.Goal`."""
        self._cancel(self)
