"""How a simulated controller and what carries its messages see each other."""

from __future__ import annotations

from enum import Enum
from typing import Any, NamedTuple, Protocol, TypeVar

from bt_orchestrator.model.goal import GoalEnd, GoalRequest


class Verdict(Enum):
    """The outcome of a goal request."""

    ACCEPT = 'accept'
    REJECT = 'reject'
    MUTE = 'mute'
    """It is never answered."""


class Answer(NamedTuple):
    """A verdict, and the reason for a rejection."""

    verdict: Verdict
    why: str = ''


class CarriedGoal(Protocol):
    """A goal that the controller accepted, as its carrier knows it."""

    @property
    def request(self) -> GoalRequest:
        """The request; without arguments where the carrier does not read them."""


GoalT_contra = TypeVar('GoalT_contra', bound=CarriedGoal, contravariant=True)


class Carrier(Protocol[GoalT_contra]):
    """Shows one controller to the outside: its action server and its state topic.

    While there is no server, it passes nothing on to the controller.
    """

    def appear(self) -> None:
        """Bring action server and state topic up."""

    def vanish(self) -> None:
        """Take both away without a word; goals are not answered."""

    def announce(self, ready: bool) -> None:
        """Say on the state topic, if there is one, whether a goal may be sent."""

    def show(self, setup: str, value: Any) -> None:
        """Say on the state topic what a setup is, as the field there says it; then `announce`."""

    def feedback(self, goal: GoalT_contra, done: float) -> None:
        """Publish feedback.

        :param done: share of the task, 0 to 1
        """

    def end(self, goal: GoalT_contra, end: GoalEnd) -> None:
        """End a goal, once, as SUCCEEDED, ABORTED or CANCELED."""

    def note(self, event: str, request: GoalRequest | None = None, **about: Any) -> None:
        """Keep a record of what the controller does; see `controllers.goal_log`.

        :param request: of the goal that it is about, if it is about one
        """
