"""The fold that measures how long each section keeps the belt at rest."""

from __future__ import annotations

import statistics
from collections import defaultdict
from collections.abc import Sequence

from bt_orchestrator.model import events as e
from bt_orchestrator.view.report.intervals import Span, common, covered_s


class TurnFold:
    """Follows when each section owes its turn: its beat has come and it is not complete (3.4)."""

    def __init__(self) -> None:
        self._beat = 1
        self._open: dict[int, tuple[int, float]] = {}
        """Beat of the turn that a section has begun, and since when it keeps the belt."""
        self._owed: dict[int, list[Span]] = defaultdict(list)
        self._first: dict[int, list[Span]] = defaultdict(list)
        """The same, before the belt has moved at all."""
        self._has_moved = False
        self._move_began_s: float | None = None
        self._moves_s: list[float] = []

    def follow(self, event: e.Event, now_s: float) -> None:
        """Take in the next event."""
        if isinstance(event, e.CycleStarted):
            self._open[event.section] = (event.beat, now_s)
        elif isinstance(event, e.TurnCompleted):
            self._complete(event.section, now_s)
        elif isinstance(event, e.BeltIndexStarted):
            self._move_began_s = now_s
            self._has_moved = True
        elif isinstance(event, (e.BeltIndexed, e.BeatStarted)):
            self._begin_beat(event.beat, now_s)

    def pace_s(self, section: int, cycles: int, worked: Sequence[Span]) -> float:
        """Return the seconds that a section needs for one of some cycles if it never waits.

        The belt is kept for as long as its work in the turn lasts, and then moves; steps that run
        while the belt moves cost nothing here. Turns before the first move are left out where
        there are others: the source could do nothing ahead of them.

        :param worked: when the tasks of these cycles ran
        """
        first = sum(any(common(worked, [span])) for span in self._first[section])
        owed = self._owed[section]
        if first == cycles:
            first, owed = 0, self._first[section]
        move_s = statistics.median(self._moves_s) if self._moves_s else 0.0
        return covered_s(common(worked, owed)) / (cycles - first) + move_s

    def _complete(self, section: int, now_s: float) -> None:
        beat, since_s = self._open.pop(section)
        if beat <= self._beat:
            owed = self._owed if self._has_moved else self._first
            owed[section].append(Span(since_s, now_s))

    def _begin_beat(self, beat: int, now_s: float) -> None:
        self._beat = beat
        if self._move_began_s is not None:
            self._moves_s.append(now_s - self._move_began_s)
            self._move_began_s = None
        for section, (turn, _) in self._open.items():
            if turn == beat:  # begun ahead, while the belt moved: no wait
                self._open[section] = (turn, now_s)
