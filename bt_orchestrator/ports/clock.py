"""Time: what everything that waits or records asks for it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from bt_orchestrator.model.uptime import Uptime


class Timer(Protocol):
    """A deadline that was set."""

    def cancel(self) -> None:
        """Forget it; harmless when it has passed."""


class Clock(Protocol):
    """Time as a port: no other code reads a wall clock or sleeps."""

    def now(self) -> float:
        """Seconds: since the epoch in a real run, from 0 in a virtual one.

        For records, and for the start of an order. It may be set forward or back, so no deadline
        uses it.
        """

    def steady(self) -> float:
        """Seconds of a monotonic clock, from an arbitrary start in this process."""

    def call_at(self, time: float, callback: Callable[[], None]) -> Timer:
        """Call back once, in the tick thread, when `steady()` has reached `time`."""

    def uptime(self) -> Uptime | None:
        """How long the machine has been up, comparable between processes.

        None: not available, or the clock does not run in real time.
        """
