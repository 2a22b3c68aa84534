"""The period of an account, and where its times are written."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from datetime import datetime, tzinfo
from fractions import Fraction
from typing import NamedTuple

from bt_orchestrator.model.plant.shifts import LANGUAGE, MICRO_STOP_S, PlantReason
from bt_orchestrator.view.report.account.planned import US, Planned
from bt_orchestrator.view.report.account.steady_time import SteadyTime

NOT_CLASSIFIED = 'not classified'
"""Said of a stop without a reason."""

_DAY_US = 24 * 3600 * US


class ChangedBreak(NamedTuple):
    """A break that is longer or shorter than usual, as the clocks change in it."""

    shift: str
    begin_us: int
    end_us: int
    usual_us: int

    @property
    def took_us(self) -> int:
        """How long it was."""
        return self.end_us - self.begin_us


MICRO_STOP_US = round(MICRO_STOP_S * US)


@dataclass(frozen=True)
class Period:
    """From when to when, and what of it is planned."""

    name: str
    begin_us: int
    end_us: int
    planned: Planned
    zone: tzinfo | None = None
    """The zone of the times in the output; None: that of the computer."""
    steady: SteadyTime | None = field(default=None, compare=False)
    """Its moments are of steady time; None: of the clock."""
    breaks: tuple[ChangedBreak, ...] = ()
    """Of its shifts, also later ones; by the clock."""
    targets: Mapping[str, Fraction] = field(default_factory=dict)
    """Figures that the plant wants, by name (`oee`), as ratios."""
    micro_stop_us: int = MICRO_STOP_US
    """A shorter own fault is a micro-stop."""
    reasons: Mapping[str, PlantReason] = field(default_factory=dict)
    """The reasons of the plant for stops, by code."""

    @classmethod
    def all_planned(
        cls, name: str, begin_us: int, end_us: int, steady: SteadyTime | None = None
    ) -> Period:
        """Return a period without shifts: all of it counts."""
        planned = Planned.of([(begin_us, end_us)])
        return cls(name, begin_us, end_us, planned, steady=steady)

    def on(self, steady: SteadyTime) -> Period:
        """Return it in steady time: a moment is in it if the clock showed a time within it."""
        if self.steady is not None:
            return self
        spans = steady.when_shown([(self.begin_us, self.end_us)])
        begin, end = (spans[0][0], spans[-1][1]) if spans else (self.begin_us, self.begin_us)
        planned = Planned.of(steady.when_shown(self.planned.pieces))
        return replace(self, begin_us=begin, end_us=end, planned=planned, steady=steady)

    @property
    def changed_breaks(self) -> tuple[ChangedBreak, ...]:
        """Breaks in it that were longer or shorter than usual."""
        begin, end = self.on_clock
        return tuple(pause for pause in self.breaks if begin <= pause.begin_us < end)

    @property
    def on_clock(self) -> tuple[int, int]:
        """The earliest and the latest time that the clock showed in it."""
        if self.steady is None:
            return self.begin_us, self.end_us
        return self.steady.clock_span(self.begin_us, self.end_us)

    def cut(self) -> Period:
        """Return it with what is planned within it alone."""
        pieces = [
            (max(begin, self.begin_us), min(end, self.end_us))
            for begin, end in self.planned.pieces
        ]
        return replace(self, planned=Planned.of(pieces))

    def when(self, us: int) -> str:
        """Write a moment."""
        return f'{datetime.fromtimestamp(self.shown_us(us) // US, self.zone):%Y-%m-%d %H:%M:%S}'

    def clock(self, us: int) -> str:
        """Write a moment without its date, or year, where that can be no other one."""
        form = '%H:%M:%S' if self.end_us - self.begin_us <= _DAY_US else '%m-%d %H:%M:%S'
        return f'{datetime.fromtimestamp(self.shown_us(us) // US, self.zone):{form}}'

    def iso(self, us: int) -> str:
        """Write a moment for a program: with its offset."""
        moment = datetime.fromtimestamp(self.shown_us(us) / US, self.zone)
        return moment.astimezone(self.zone).isoformat()

    def reason_words(self, code: str, language: str = LANGUAGE) -> str:
        """Say a reason; one that is not in the plant's file by its code."""
        known = self.reasons.get(code)
        return (known.said(language) if known is not None else code) or NOT_CLASSIFIED

    def shown_us(self, us: int) -> int:
        """Return what the clock showed at a moment."""
        return us if self.steady is None else self.steady.clock_us(us)
