"""One goal in virtual time."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from bt_orchestrator.model.goal import GoalEnd, GoalRequest
from bt_orchestrator.ports import Timer


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
