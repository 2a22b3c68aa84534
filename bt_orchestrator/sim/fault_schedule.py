"""The fault that strikes at each goal of one simulated controller."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from bt_orchestrator.model.fault import Fault, FaultKind


@dataclass(frozen=True)
class GoalFaults:
    """The faults that strike at one goal; of several of one sort the first one listed counts."""

    faults: tuple[Fault, ...] = ()
    goal: int = 0
    """The number of the goal of the component, from 1."""

    def has(self, kind: FaultKind) -> bool:
        """Tell whether a fault of this kind strikes."""
        return self.find(kind) is not None

    def find(self, *kinds: FaultKind) -> Fault | None:
        """Return the first fault of these kinds."""
        if not self.faults:
            return None
        return next((fault for fault in self.faults if fault.kind in kinds), None)

    @property
    def late_s(self) -> float:
        """Seconds beyond the nominal duration."""
        late = self.find(FaultKind.LATE)
        return late.seconds or 0.0 if late else 0.0


class FaultSchedule:
    """Counts the goals of one component.

    The count belongs to the simulation, not to the server: a server that died and came back knows
    nothing, yet its next goal is not the first one again.
    """

    def __init__(self, faults: Sequence[Fault]) -> None:
        self._faults = tuple(faults)
        self._count = 0
        self._count_of_task: Counter[str] = Counter()

    def at_start(self, kind: FaultKind) -> Fault | None:
        """Return the fault of this kind that is there from the start (`#0`)."""
        return next((f for f in self._faults if f.nth == 0 and f.kind is kind), None)

    def next_goal(self, task: str) -> GoalFaults:
        """Count one more goal of a task and return what strikes at it."""
        self._count += 1
        if not self._faults:
            return GoalFaults(goal=self._count)
        self._count_of_task[task] += 1
        counts = self._count, self._count_of_task[task]
        striking = tuple(f for f in self._faults if f.strikes(task, *counts))
        return GoalFaults(striking, self._count)
