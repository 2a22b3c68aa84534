"""How much of the thread's time publishing for watchers may take."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

SHARE = 0.05
"""Largest part of the thread's time that publishing may take: a large tree is shown less often."""

AFTER_ERROR_S = 1.0
"""When to try again after a turn that failed."""


class Pace:
    """Says after each turn when the next one may begin.

    What a turn has taken is counted in time of the processor. By the clock it may have taken a
    hundred times as long, where other programs had their turn meanwhile; after a pause of twenty
    times that, watchers would have missed whole jobs.
    """

    def __init__(self, used_s: Callable[[], float] = time.thread_time) -> None:
        """Allow a turn.

        :param used_s: returns the seconds that the processor has worked for this thread
        """
        self._used_s = used_s
        self._resume_at = -math.inf

    def may_begin(self, now: float) -> bool:
        """Tell whether a turn may begin.

        :param now: seconds, of a clock that does not jump
        """
        return now >= self._resume_at

    @contextmanager
    def turn(self, now: float) -> Iterator[None]:
        """Count what is done within as a turn that began now."""
        self._resume_at = now + AFTER_ERROR_S
        used_s = self._used_s()
        yield
        self._resume_at = now + (self._used_s() - used_s) / SHARE
