"""Detecting that the wall clock was set (semantics 2.4)."""

from __future__ import annotations

from bt_orchestrator.ports import Clock

STEP_S = 1.0
"""A smaller step counts as slewing; NTP corrections of a slow or fast clock are far smaller."""


class WallClock:
    """Compares how far the wall clock and the steady clock have moved since the last look.

    So a slewed clock is followed. A step of less than STEP_S counts as slewing.
    """

    def __init__(self, clock: Clock) -> None:
        self._now, self._steady = clock.now, clock.steady
        self.now = 0.0
        """As it was at the last look."""
        self.steady = 0.0
        """The steady clock at the last look."""
        self._ahead_s = self._look()

    def step_s(self) -> float:
        """Return by how many seconds it was set since the last look; 0.0: it was not set."""
        ahead_s = self._look()
        if -STEP_S < ahead_s - self._ahead_s < STEP_S:
            self._ahead_s = ahead_s
            return 0.0
        # Read again: the process may have been suspended between the two readings.
        ahead_s = self._look()
        step_s, self._ahead_s = ahead_s - self._ahead_s, ahead_s
        return step_s if abs(step_s) >= STEP_S else 0.0

    def _look(self) -> float:
        self.now, self.steady = self._now(), self._steady()
        return self.now - self.steady
