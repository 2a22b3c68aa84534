"""The period of an account, and where its times are written."""

from __future__ import annotations

from dataclasses import dataclass, replace
from datetime import datetime, tzinfo

from bt_orchestrator.report.account.planned import US, Planned

_DAY_US = 24 * 3600 * US


@dataclass(frozen=True)
class Period:
    """From when to when, and what of it is planned."""

    name: str
    begin_us: int
    end_us: int
    planned: Planned
    zone: tzinfo | None = None
    """In which times are told; None: that of the computer."""

    @classmethod
    def all_planned(cls, name: str, begin_us: int, end_us: int) -> Period:
        """Return a period without shifts: all of it counts."""
        return cls(name, begin_us, end_us, Planned.of([(begin_us, end_us)]))

    @property
    def until_s(self) -> float:
        """Its end as a time of events: one that is rounded to the end is in it."""
        return (self.end_us + 0.5) / US

    def cut(self) -> Period:
        """Return it with what is planned within it alone."""
        pieces = [
            (max(begin, self.begin_us), min(end, self.end_us))
            for begin, end in self.planned.pieces
        ]
        return replace(self, planned=Planned.of(pieces))

    def when(self, us: int) -> str:
        """Write a moment."""
        return f'{datetime.fromtimestamp(us // US, self.zone):%Y-%m-%d %H:%M:%S}'

    def clock(self, us: int) -> str:
        """Write a moment without its date, or year, where that can be no other one."""
        form = '%H:%M:%S' if self.end_us - self.begin_us <= _DAY_US else '%m-%d %H:%M:%S'
        return f'{datetime.fromtimestamp(us // US, self.zone):{form}}'

    def iso(self, us: int) -> str:
        """Write a moment for a program: with its offset."""
        return datetime.fromtimestamp(us / US, self.zone).astimezone(self.zone).isoformat()
