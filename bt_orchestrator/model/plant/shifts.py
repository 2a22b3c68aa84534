"""Shifts of a plant, and its reasons for stops. No part of a cell's definition."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction

DAY_MIN = 24 * 60
MICRO_STOP_S, LEAST_MICRO_STOP_S = 300.0, 10.0
EVERY_DAY = tuple(range(7))
DAYS = ('mon', 'tue', 'wed', 'thu', 'fri', 'sat', 'sun')


@dataclass(frozen=True)
class Hours:
    """From one time of the clock to another, in minutes after midnight."""

    begin_min: int
    end_min: int
    """Where it is not later than the begin: on the next day."""

    @property
    def minutes(self) -> int:
        """How long it is by the clock; the same time twice is a whole day."""
        return (self.end_min - self.begin_min - 1) % DAY_MIN + 1


WHOLE_DAY = Hours(0, 0)


@dataclass(frozen=True)
class Shift:
    """One shift."""

    name: str
    hours: Hours
    breaks: tuple[Hours, ...] = ()
    days: tuple[int, ...] = EVERY_DAY
    """Days of the week on which it begins, from 0 for Monday."""


@dataclass(frozen=True)
class Shifts:
    """All shifts of a file."""

    shifts: Mapping[str, Shift]
    zone: str = ''
    """Name of the time zone (IANA); empty: that of the computer."""
    targets: Mapping[str, Fraction] = field(default_factory=dict)
    """Figures that the plant wants, by name (`oee`, `availability`, `performance`, `quality`)."""
    micro_stop_s: float = MICRO_STOP_S
    """An own fault that is shorter is a micro-stop, any other a breakdown."""


# The reasons of a plant for stops of a line, by code.

LANGUAGE = 'en'
"""Of reports, and where a reason has no words in the language that is wanted."""


@dataclass(frozen=True)
class PlantReason:
    """One reason."""

    code: str
    words: Mapping[str, str]
    """By language, as in `de`; at least one."""
    group: str = ''

    def said(self, language: str = LANGUAGE) -> str:
        """Return it in a language, else in English, else in the first that the file has."""
        return next(
            (self.words[name] for name in (language, LANGUAGE) if name in self.words),
            next(iter(self.words.values())),
        )
