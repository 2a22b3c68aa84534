"""The pace of answers that nobody hears, for all services of a node together."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

from bt_orchestrator.model.allowance import Allowance
from bt_orchestrator.model.limits import UNHEARD_TOGETHER_S

PAUSE_S = 0.05
"""Pause after an answer that was not heard: whatever else is ready has its turn."""

Later = Callable[[float, Callable[[], None]], None]


class Turns:
    """Pauses after each answer that was not heard; then one service after the other goes on.

    Such an answer blocks the tick thread for 0.1 s, and several of them may be due at a time.
    """

    def __init__(self) -> None:
        self._waiting: deque[Callable[[], None]] = deque()
        self._allowance = Allowance(UNHEARD_TOGETHER_S)
        self.pauses = False
        """Whether nothing is to be sent now."""

    def left(self, now: float) -> float:
        """Return how many seconds may be spent now; below 0: overdrawn."""
        return self._allowance.left(now)

    def use(self, seconds: float, now: float, later: Later) -> None:
        """Note an answer that was not heard, and pause.

        :param later: calls back once, after so many seconds
        """
        self._allowance.use(seconds, now)
        if not self.pauses:
            self.pauses = True
            later(PAUSE_S, self._go_on)

    def wait(self, go_on: Callable[[], None]) -> None:
        """Call back after the pause, after those that came before."""
        self._waiting.append(go_on)

    def _go_on(self) -> None:
        self.pauses = False
        while self._waiting and not self.pauses:
            self._waiting.popleft()()
