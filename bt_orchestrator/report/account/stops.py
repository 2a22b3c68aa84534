"""Sums of time by cause, and the holds that took most of it."""

from __future__ import annotations

import heapq
from collections import Counter
from dataclasses import dataclass
from typing import NamedTuple

from bt_orchestrator.model import events as e
from bt_orchestrator.model.hold_words import hold_words
from bt_orchestrator.report.account.losses import WORDS, Loss, Step
from bt_orchestrator.report.account.standing import Cause
from bt_orchestrator.report.account.words import is_seen

MOST_HOLDS = 100
"""Holds that are told one by one: those that cost most. Of all others number and time."""

_REMARKS = ('acknowledge', 'comment')
"""Answers that change nothing."""


class Stop(NamedTuple):
    """All stops for one cause."""

    loss: Loss
    detail: str
    component: str
    times: int
    us: int

    @property
    def about(self) -> str:
        """What exactly, with its component."""
        if self.component in self.detail:
            return self.detail
        return f'{self.component}, {self.detail}'

    @property
    def is_shown(self) -> bool:
        """Tell whether it is a stop of the line that can be seen beside the others."""
        return WORDS[self.loss].step is Step.AVAILABILITY and is_seen(self.us)


@dataclass
class Held:
    """One hold that stood in planned time."""

    hold: str
    words: str
    raised_us: int
    released_us: int | None = None
    """None: it stands."""
    loss: Loss | None = None
    """What its time is booked as; None: another hold was older all the time."""
    stood_us: int = 0
    """Planned time in which it stood."""
    lost_us: int = 0
    """What is booked to it."""
    who: str = ''
    answer: str = ''
    reason: str = ''
    """Why somebody answered so."""


class StopBook:
    """Books time by cause, and on the oldest of the holds that stand."""

    def __init__(self) -> None:
        self.left_out: Counter[Loss] = Counter()
        """Time of the holds that are not told one by one."""
        self.left_out_count = 0
        self._us: Counter[tuple[Loss, str, str]] = Counter()
        self._count: Counter[tuple[Loss, str, str]] = Counter()
        self._last: tuple[Cause | None, int] = (None, 0)
        self._open: dict[str, Held] = {}
        self._told: list[tuple[int, int, int, Held]] = []
        self._number = 0
        self._said: e.OperatorDecided | None = None

    def book(self, cause: Cause, us: int, begin: int, end: int) -> None:
        """Book time that was lost.

        :param us: how much of it was planned
        """
        key = cause[:3]
        self._us[key] += us
        last, until = self._last
        if last != cause or until != begin:
            self._count[key] += 1
        self._last = cause, end
        held = self._open.get(cause.hold)
        if held is not None:
            held.loss = cause.loss
            held.lost_us += us

    def stand(self, us: int) -> None:
        """Let planned time pass for all holds that stand."""
        for held in self._open.values():
            held.stood_us += us

    def follow(self, event: e.Event, now: int) -> None:
        """Take in the next event."""
        if isinstance(event, e.HoldRaised):
            self._open[event.hold] = Held(event.hold, hold_words(event), now)
        elif isinstance(event, e.OperatorDecided):
            self._decided(event)
        elif isinstance(event, e.HoldReleased):
            held = self._open.pop(event.hold, None)
            if held is not None:
                held.released_us = now
                if not held.answer and self._said is not None:
                    _answer(held, self._said)
                self._keep(held)
        elif not isinstance(event, e.ItemRemoved):
            self._said = None

    def stops(self) -> tuple[Stop, ...]:
        """Return the stops, the longest first."""
        found = (Stop(*key, self._count[key], us) for key, us in self._us.items())
        return tuple(sorted(found, key=lambda one: (-one.us, one.loss.value, one.detail)))

    def end(self) -> None:
        """Count the holds that still stand, as the account ends here."""
        for held in self._open.values():
            self._keep(held)
        self._open.clear()

    def holds(self) -> tuple[Held, ...]:
        """Return the holds that stood in planned time and cost most, in their order."""
        return tuple(sorted((one[3] for one in self._told), key=lambda held: held.raised_us))

    def _decided(self, event: e.OperatorDecided) -> None:
        held = self._open.get(event.hold or '')
        if held is None:
            self._said = event  # `resume` and `remove-item` name no hold, and release it at once
        elif event.answer not in _REMARKS:
            _answer(held, event)

    def _keep(self, held: Held) -> None:
        if not held.stood_us:
            return
        self._number += 1
        entry = (held.lost_us, held.stood_us, -self._number, held)
        if len(self._told) < MOST_HOLDS:
            heapq.heappush(self._told, entry)
            return
        left = heapq.heappushpop(self._told, entry)[3]
        self.left_out_count += 1
        if left.loss is not None:
            self.left_out[left.loss] += left.lost_us


def _answer(held: Held, event: e.OperatorDecided) -> None:
    held.who, held.answer, held.reason = event.who, event.answer, event.reason
