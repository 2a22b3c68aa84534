"""When shifts are: their hours on a day, in the time zone of the plant."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import date, datetime, time, timedelta, tzinfo
from zoneinfo import ZoneInfo

from bt_orchestrator.model.plant.shifts import Hours, Shift, Shifts
from bt_orchestrator.report.account.period import Period
from bt_orchestrator.report.account.planned import US, Planned, us_of

_LOOK_BACK_DAYS = 8
"""A shift of one day of the week has begun within these."""


def zone_of(shifts: Shifts) -> tzinfo | None:
    """Return the time zone of shifts; None: that of the computer."""
    return ZoneInfo(shifts.zone) if shifts.zone else None


def shift_on(shift: Shift, day: date, zone: tzinfo | None, until: float) -> Period:
    """Return the period of a shift that begins on a day, as far as it has passed.

    :param until: now, seconds since the epoch
    """
    begin, end = _span(shift.hours, day, zone)
    return Period(shift.name, begin, min(end, us_of(until)), _planned(shift, day, zone), zone)


def last_begun(shift: Shift, zone: tzinfo | None, until: float) -> date | None:
    """Return the day on which a shift has begun last; None: on none of the last week.

    :param until: now, seconds since the epoch
    """
    today = datetime.fromtimestamp(until, zone).date()
    for day in (today - timedelta(days=back) for back in range(_LOOK_BACK_DAYS)):
        if day.weekday() in shift.days and _span(shift.hours, day, zone)[0] < us_of(until):
            return day
    return None


def planned_within(shifts: Shifts, begin: int, end: int) -> Planned:
    """Return the planned time of all shifts between two moments."""
    zone = zone_of(shifts)
    pieces = [
        (max(here, begin), min(there, end))
        for day in _days(begin, end, zone)
        for shift in shifts.shifts.values()
        if day.weekday() in shift.days
        for here, there in _planned(shift, day, zone).pieces
        if here < end and there > begin
    ]
    return Planned.of(pieces)


def _days(begin: int, end: int, zone: tzinfo | None) -> Iterator[date]:
    """Yield the days on which a shift may begin that touches a period."""
    day = datetime.fromtimestamp(begin / US, zone).date() - timedelta(days=1)
    last = datetime.fromtimestamp(end / US, zone).date()
    while day <= last:
        yield day
        day += timedelta(days=1)


def _planned(shift: Shift, day: date, zone: tzinfo | None) -> Planned:
    off = []
    for pause in shift.breaks:
        is_later = pause.begin_min < shift.hours.begin_min
        off.append(_span(pause, day + timedelta(days=is_later), zone))
    return Planned.of([_span(shift.hours, day, zone)], off)


def _span(hours: Hours, day: date, zone: tzinfo | None) -> tuple[int, int]:
    """Return the begin and end of hours; a day on which clocks change is longer or shorter."""
    begin_us = _moment(day, hours.begin_min, zone)
    days, minute = divmod(hours.begin_min + hours.minutes, 24 * 60)
    return begin_us, _moment(day + timedelta(days=days), minute, zone)


def _moment(day: date, minute: int, zone: tzinfo | None) -> int:
    at = datetime.combine(day, time(minute // 60, minute % 60), zone)
    return us_of(at.timestamp())
