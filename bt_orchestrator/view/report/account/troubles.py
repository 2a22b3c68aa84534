"""Failures: of tasks by component, and of components with the time to their repair."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from bt_orchestrator.model import events as e
from bt_orchestrator.model.goal import Reason

OF_COMPONENTS = (
    Reason.SERVER_UNAVAILABLE,
    Reason.GOAL_REJECTED,
    Reason.ABORTED,
    Reason.TIMEOUT,
    Reason.TASK_RESULT_FALSE,
    Reason.SERVER_LOST,
    Reason.IN_DOUBT,
)
"""Why a hold is a failure of its component; all else is about data, an item or a command."""

_REASONS = frozenset(one.value for one in OF_COMPONENTS)


def failing_component(hold: e.HoldRaised) -> str:
    """Return the component whose failure a hold is; empty: the hold is no failure."""
    return hold.component if hold.reason in _REASONS else ''


class FailingTask(NamedTuple):
    """All attempts of a task that failed for one reason."""

    component: str
    """Empty: nothing was sent."""
    task: str
    """Task constant; where nothing was sent the id of the task."""
    reason: str
    times: int
    us: int
    """How long these attempts took."""


@dataclass
class Repairs:
    """Failures of one component that needed a person."""

    component: str
    failures: int = 0
    down_us: int = 0
    """Planned busy time from its holds to their release."""
