"""The speed of the line: how often the belt has moved lately."""

from __future__ import annotations

from collections import deque

from bt_orchestrator.model.events import BeltIndexed, CellStateChanged, ClockStepped, Event
from bt_orchestrator.model.packml import PackmlState

MOVES = 10
"""Moves that the speed is the mean of."""


class Speedometer:
    """Hears the moves of the belt since the cell began to execute, in one journal."""

    def __init__(self) -> None:
        self._marks: deque[float] = deque(maxlen=MOVES + 1)
        """Times of moves; the first may be that of the beginning."""

    def hear(self, event: Event) -> None:
        """Take note of an event."""
        if isinstance(event, CellStateChanged):
            self._marks.clear()
            if event.state == PackmlState.EXECUTE.value:
                self._marks.append(event.time)
        elif isinstance(event, BeltIndexed):
            self._marks.append(event.time)
        elif isinstance(event, ClockStepped):
            for at, mark in enumerate(self._marks):
                self._marks[at] = mark + event.seconds

    def a_minute(self, state: PackmlState, now: float) -> float | None:
        """Return the moves a minute; each brings every item one section further.

        None: not known yet, because less than two moves were heard of. It falls while a move is
        overdue, and is 0 in every state in which the belt stands still.
        """
        if state is not PackmlState.EXECUTE:
            return 0.0
        moves = len(self._marks) - 1
        if moves < 1 or self._marks[-1] <= self._marks[0]:
            return None
        took = self._marks[-1] - self._marks[0]
        if_it_moved_now = 60.0 * (moves + 1) / max(now - self._marks[0], took)
        return min(60.0 * moves / took, if_it_moved_now)
