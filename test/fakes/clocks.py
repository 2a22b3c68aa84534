"""Clocks that go wrong."""

from __future__ import annotations

from bt_orchestrator.model.uptime import Uptime
from bt_orchestrator.sim.gateway import VirtualClock


class SetClock(VirtualClock):
    """A wall clock that somebody sets, on a machine that may be another one, or start anew."""

    def __init__(self) -> None:
        super().__init__()
        self.ahead_s = 0.0
        """How far the wall clock is from what it would be, had nobody set it."""
        self.boot: str | None = 'first machine'
        """None: the machine does not tell."""
        self.booted_s = 0.0

    def now(self) -> float:
        return super().now() + self.ahead_s

    def uptime(self) -> Uptime | None:
        return None if self.boot is None else Uptime(self.boot, self.steady() - self.booted_s)

    def sleep(self, seconds: float) -> None:
        """Let time pass, and nothing happen."""
        until = self.steady() + seconds
        self.call_at(until, lambda: None)
        while self.steady() < until:
            self.advance()
