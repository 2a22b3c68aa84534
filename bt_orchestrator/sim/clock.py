"""Virtual time: it moves only when asked, straight to the next deadline."""

from __future__ import annotations

from collections.abc import Callable

from bt_orchestrator.base.deadlines import NS_PER_S, Deadline, Deadlines, instant_ns
from bt_orchestrator.model.uptime import Uptime


class VirtualClock:
    """Time as a number. Implements `ports.Clock`.

    Inside it counts integer nanoseconds: 1.5 + 1.0 and 2.5 are one instant, and ties are ties.
    """

    def __init__(self, start_s: float = 0.0) -> None:
        self._now_ns = instant_ns(start_s)
        self._now_s = self._now_ns / NS_PER_S
        self._deadlines = Deadlines()

    def now(self) -> float:
        """Return the virtual seconds; they count from 0 unless the start is another."""
        return self._now_s

    def steady(self) -> float:
        """Return the same: a virtual clock is never set."""
        return self._now_s

    def uptime(self) -> Uptime | None:
        """Return the same, of a machine that is never booted again."""
        return Uptime('virtual', self._now_s)

    def call_at(self, time: float, callback: Callable[[], None]) -> Deadline:
        """Call back in `advance` when time has come; a time that has passed means now."""
        return self._deadlines.add(max(instant_ns(time), self._now_ns), callback)

    def next_deadline(self) -> float | None:
        """Return the seconds to which `advance` would move; None when nothing is armed."""
        time_ns = self._deadlines.next_ns()
        return None if time_ns is None else time_ns / NS_PER_S

    def advance(self) -> bool:
        """Move to the next deadline and run every callback due there, in the order armed.

        Those that a callback arms for the same instant run too, so that afterwards nothing is due.

        :return: False, without moving, when nothing is armed
        """
        time_ns = self._deadlines.next_ns()
        if time_ns is None:
            return False
        self._now_ns, self._now_s = time_ns, time_ns / NS_PER_S
        while callback := self._deadlines.pop_due(time_ns):
            callback()
        return True
