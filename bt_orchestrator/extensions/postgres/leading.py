"""The lease of the leader of a cell (semantics 9.4).

The leader is the newest writer: each one raises the epoch of the cell, and no write with an older
epoch is taken. So a leader that has just written knows that no other node had taken over when it
began. It may send goals for `GUARD_S` after that, by a clock of its own, and no longer. The server
keeps its lock for `IDLE_S` after its last word, which is more.
"""

from __future__ import annotations

import math
import time
from collections import deque
from typing import NamedTuple

from bt_orchestrator.model.uptime import ClockReading

GUARD_S = 3.0
"""How long a leader may send goals after the beginning of its last confirmed write."""

RENEW_S = 1.0
"""Age of the last confirmed write from which an idle leader writes something for its own sake."""

IDLE_S = 5
"""Silence after which the server ends the session of a leader, and with it the lock."""

STARTING_IDLE_S = 60
"""The same before the first write: a long journal is read, and nothing runs yet."""

WRITING = (
    'SET plan_cache_mode = force_generic_plan',
    f'SET idle_session_timeout = {STARTING_IDLE_S * 1000}',
    'SET client_connection_check_interval = 1000',
    'SET tcp_keepalives_idle = 2',
    'SET tcp_keepalives_interval = 1',
    'SET tcp_keepalives_count = 3',
    'SET tcp_user_timeout = 5000',
)
"""Settings of the session that writes. The first makes an append faster; by the others the server
notices that a leader is gone, also one whose cable was cut."""

ABIDING = f'SET idle_session_timeout = {IDLE_S * 1000}'
"""From the first write on."""


class Lease:
    """When this leader was confirmed last. Any thread reads it; one writes."""

    def __init__(self) -> None:
        self._confirmed_s = -math.inf

    @property
    def age_s(self) -> float:
        """Seconds since the beginning of the last write that was confirmed."""
        return now_s() - self._confirmed_s

    @property
    def holds(self) -> bool:
        """Tell whether no node can act on a later epoch yet."""
        return self.age_s < GUARD_S

    def confirm(self, began_s: float) -> None:
        """Note that a write was confirmed whose statement compared the epoch.

        :param began_s: when it began, by `now_s`
        """
        self._confirmed_s = began_s


def now_s() -> float:
    """Return seconds of a clock that is never set, and that goes on while the machine sleeps."""
    return time.clock_gettime(getattr(time, 'CLOCK_BOOTTIME', time.CLOCK_MONOTONIC))


# What a standby has seen of a journal, and when.

KEPT_S = 900.0
"""Age of looks that are forgotten. Servers that remember goals for longer are not made use of."""


class _Look(NamedTuple):
    seq: int
    """The last event that was there."""
    at: ClockReading
    """When the last look began that saw no later event."""


class Looks:
    """Since when events were there, at the latest; of one history."""

    def __init__(self) -> None:
        self._looks: deque[_Look] = deque()

    def note(self, seq: int, began: ClockReading) -> None:
        """Note what a look at the primary saw.

        :param began: when the look began: whatever it did not see was committed later
        """
        if self._looks and seq < self._looks[-1].seq:
            self._looks.clear()  # another history, or events were lost
        elif self._looks and seq == self._looks[-1].seq:
            self._looks.pop()
        self._looks.append(_Look(seq, began))
        while self._looks[0].at.up.seconds < began.up.seconds - KEPT_S:
            self._looks.popleft()

    def clear(self) -> None:
        """Forget all."""
        self._looks.clear()

    def absent_at(self, seq: int) -> ClockReading | None:
        """Return when the last look began that did not show an event; None: there was none."""
        return next((look.at for look in reversed(self._looks) if look.seq < seq), None)
