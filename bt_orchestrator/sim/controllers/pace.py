"""How fast simulated controllers run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from bt_orchestrator.model.uptime import Uptime
from bt_orchestrator.ports import Clock, Timer


@dataclass(frozen=True)
class Pace:
    """How fast the simulated cell runs."""

    speed: float = 1.0
    """All simulated seconds, those of faults too, are divided by this."""
    feedback_s: float = 0.5
    """Real seconds between two feedback messages of a goal; 0: only the one at its start."""


class PacedClock:
    """A clock that runs faster or slower than another. Implements `ports.Clock`.

    `now()` stays what it is: records are compared with those of other programs.
    """

    def __init__(self, clock: Clock, speed: float) -> None:
        self._clock = clock
        self._speed = speed

    def now(self) -> float:
        """Return the other clock's time."""
        return self._clock.now()

    def steady(self) -> float:
        """Return steady seconds of this clock."""
        return self._clock.steady() * self._speed

    def uptime(self) -> Uptime | None:
        """Return the other clock's."""
        return self._clock.uptime()

    def call_at(self, time: float, callback: Callable[[], None]) -> Timer:
        """Call back once `steady()` has reached a time."""
        return self._clock.call_at(time / self._speed, callback)
