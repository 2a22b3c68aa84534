"""The pace of answers without a reader, for all services of a node together."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

from bt_orchestrator.model.allowance import Allowance
from bt_orchestrator.model.limits import UNHEARD_TOGETHER_S

LONG_S = 0.05
"""A try that took longer has kept the thread from others; the next one lets them go first."""

PAUSE = 0.5
"""Pause after a long try, as a share of the time that it took: whatever else is ready has its
turn."""

Later = Callable[[float, Callable[[], None]], object]


class Turns:
    """Pauses after each long try that was not heard; then one service after the other goes on.

    Such a try may block the tick thread for 0.1 s, and many of them may be due at a time.
    """

    def __init__(self, later: Later) -> None:
        """Begin without a pause.

        :param later: calls back once, after so many seconds
        """
        self.later = later
        self._waiting: deque[Callable[[], None]] = deque()
        self._allowance = Allowance(UNHEARD_TOGETHER_S)
        self.pauses = False
        """Whether nothing is to be sent now."""

    def left(self, now: float) -> float:
        """Return how many seconds may be spent now; below 0: overdrawn."""
        return self._allowance.left(now)

    def use(self, seconds: float, now: float) -> None:
        """Note an answer that was not heard, and pause if it took long."""
        self._allowance.use(seconds, now)
        if seconds > LONG_S and not self.pauses:
            self.pauses = True
            self.later(PAUSE * seconds, self._go_on)

    def wait(self, go_on: Callable[[], None]) -> None:
        """Call back after the pause, after those that came before."""
        self._waiting.append(go_on)

    def _go_on(self) -> None:
        self.pauses = False
        while self._waiting and not self.pauses:
            self._waiting.popleft()()
