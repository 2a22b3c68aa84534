"""How a simulated controller and what carries its messages see each other."""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from typing import Any, Protocol

from bt_orchestrator.model.goal import GoalStatus


class Answer(Enum):
    """What happens to a goal request."""

    ACCEPT = 'accept'
    REJECT = 'reject'
    MUTE = 'mute'
    """It is never answered."""


class ActiveGoal(Protocol):
    """A goal that the server accepted and that has not ended."""

    @property
    def id(self) -> str:
        """Its UUID."""

    def feedback(self, text: str) -> None:
        """Publish feedback."""

    def end(self, status: GoalStatus, result: Mapping[str, Any]) -> None:
        """End it, once, as SUCCEEDED, ABORTED or CANCELED."""


class Presence(Protocol):
    """How a controller is seen from outside: its action server and its state topic."""

    def appear(self) -> None:
        """Bring action server and state topic up."""

    def vanish(self) -> None:
        """Take both away; goals are not answered."""

    def announce(self, ready: bool) -> None:
        """Say on the state topic whether a goal may be sent."""

    def warn(self, text: str) -> None:
        """Tell a person what happened."""
