"""Failures: of tasks by component, and of components with the time to their repair."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import NamedTuple

from bt_orchestrator.model import events as e
from bt_orchestrator.model.goal import Reason
from bt_orchestrator.report.task_spans import TaskSpan

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


class TroubleBook:
    """Counts failed attempts and the holds of components."""

    def __init__(self) -> None:
        self._failures: Counter[tuple[str, str, str]] = Counter()
        self._took: Counter[tuple[str, str, str]] = Counter()
        self._down: dict[str, str] = {}
        """Component by hold."""
        self._counted: set[str] = set()
        self._repairs: dict[str, Repairs] = {}

    def failed(self, event: e.TaskFailed, span: TaskSpan | None) -> None:
        """Take in an attempt that failed in planned time."""
        begun = span.started if span is not None else None
        key = (begun.component if begun else '', begun.name if begun else event.task, event.reason)
        self._failures[key] += 1
        self._took[key] += max(0, round(span.seconds * 1e6)) if span is not None else 0

    def raised(self, hold: e.HoldRaised, *, is_busy: bool) -> None:
        """Take in a hold.

        :param is_busy: in planned busy time
        """
        if hold.component and hold.reason in _REASONS:
            self._down[hold.hold] = hold.component
            if is_busy:
                self._count(hold.hold)

    def released(self, hold: str) -> None:
        """Take in that a hold is over."""
        self._down.pop(hold, None)
        self._counted.discard(hold)

    def stand(self, us: int) -> None:
        """Let planned busy time pass."""
        for hold, component in self._down.items():
            self._count(hold)
            self._repairs[component].down_us += us

    def failing(self) -> tuple[FailingTask, ...]:
        """Return the tasks that failed, the most frequent first."""
        found = (
            FailingTask(*key, count, self._took[key]) for key, count in self._failures.items()
        )
        return tuple(sorted(found, key=lambda one: (-one.times, -one.us, one[:3])))

    def repairs(self) -> tuple[Repairs, ...]:
        """Return the components that failed, the longest down first."""
        return tuple(sorted(self._repairs.values(), key=lambda one: (-one.down_us, one.component)))

    def _count(self, hold: str) -> None:
        if hold not in self._counted:
            self._counted.add(hold)
            component = self._down[hold]
            self._repairs.setdefault(component, Repairs(component)).failures += 1
