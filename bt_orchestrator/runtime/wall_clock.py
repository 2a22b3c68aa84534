"""Noticing that somebody set the wall clock (semantics 2.4)."""

from __future__ import annotations

from bt_orchestrator.ports import Clock

STEP_S = 1.0
"""From this on it was set; what NTP does to a clock that is only slow, or fast, is far less."""


class WallClock:
    """Compares the wall clock with the steady one, at every look with the look before.

    So a clock that is slewed is followed. One that is set by less than STEP_S counts as slewed.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self.now = 0.0
        """As it was at the last look."""
        self._ahead_s = self._look()

    def step_s(self) -> float:
        """Return by how many seconds it was set since the last look; 0.0: it was not."""
        ahead_s = self._look()
        if abs(ahead_s - self._ahead_s) >= STEP_S:
            # Once more: the process may have stood still between the two clocks.
            ahead_s = self._look()
        step_s, self._ahead_s = ahead_s - self._ahead_s, ahead_s
        return step_s if abs(step_s) >= STEP_S else 0.0

    def _look(self) -> float:
        self.now = self._clock.now()
        return self.now - self._clock.steady()
