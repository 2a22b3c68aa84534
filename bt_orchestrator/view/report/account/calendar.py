"""When shifts are: their hours on a day, in the time zone of the plant."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from datetime import date, datetime, time, timedelta, tzinfo
from typing import NamedTuple
from zoneinfo import ZoneInfo

from bt_orchestrator.model.plant.shifts import WHOLE_DAY, Hours, Shift, Shifts
from bt_orchestrator.view.report.account.period import ChangedBreak, Period
from bt_orchestrator.view.report.account.planned import US, Planned, us_of

_LOOK_BACK_DAYS = 8
"""A shift of one day of the week has begun within these."""

_LOOK_BACK_US = _LOOK_BACK_DAYS * 24 * 3600 * US


def zone_of(shifts: Shifts) -> tzinfo | None:
    """Return the time zone of shifts; None: that of the computer."""
    return ZoneInfo(shifts.zone) if shifts.zone else None


class Turn(NamedTuple):
    """One shift of one day."""

    shift: str
    """Its name in the file of shifts."""
    day: date
    """On which it begins."""
    period: Period
    """From its begin to its end, whatever of it has passed."""


class Now(NamedTuple):
    """The question at a moment, whose account grows with the time."""

    period: Period
    """As a whole, with what is still to come."""
    turn: Turn | None = None
    """The shift; None: no shift."""
    next: Turn | None = None
    """The shift that begins next, if none runs; the period is the one of the last that ended."""


def shift_at(shifts: Shifts, now: float) -> Now:
    """Return the shift that runs; the one that began last, if there are several.

    :param now: seconds since the epoch
    """
    moment, zone = us_of(now), zone_of(shifts)
    turns = list(_turns(shifts, moment - _LOOK_BACK_US, moment + _LOOK_BACK_US, zone))
    begun = [turn for turn in turns if turn.period.begin_us <= moment]
    running = [turn for turn in begun if turn.period.end_us > moment]
    if running:
        turn = max(running, key=lambda turn: turn.period.begin_us)
        return Now(turn.period, turn)
    turn = max(begun, key=lambda turn: turn.period.end_us)
    coming = (turn for turn in turns if turn.period.begin_us > moment)
    return Now(turn.period, turn, min(coming, key=lambda turn: turn.period.begin_us))


def _turns(shifts: Shifts, begin: int, end: int, zone: tzinfo | None) -> Iterator[Turn]:
    """Yield the shifts that begin about between two moments."""
    return turns_on(shifts, _days(begin, end, zone), zone)


def turns_on(shifts: Shifts, days: Iterable[date], zone: tzinfo | None) -> Iterator[Turn]:
    """Yield the shifts that begin on some days, those of a day in the order of the file."""
    for day in days:
        for shift in shifts.shifts.values():
            if day.weekday() in shift.days:
                period = shift_on(shift, day, zone)
                yield Turn(shift.name, day, wanted_by(shifts, period))


def wanted_by(shifts: Shifts, period: Period) -> Period:
    """Return a period with the targets and the threshold of a file of shifts."""
    return replace(period, targets=shifts.targets, micro_stop_us=round(shifts.micro_stop_s * US))


def shift_on(shift: Shift, day: date, zone: tzinfo | None, until: float | None = None) -> Period:
    """Return the period of a shift that begins on a day.

    :param until: now, seconds since the epoch, for what of it has passed; None: all of it
    """
    begin, end = _span(shift.hours, day, zone)
    name = f'shift {shift.name} of {day}'
    return Period(
        name,
        begin,
        end if until is None else min(end, us_of(until)),
        _planned(shift, day, zone),
        zone,
        breaks=_changed(shift, day, zone),
    )


def day_on(day: date, zone: tzinfo | None, until: float | None = None) -> Period:
    """Return the period of a day, as that of a shift."""
    return replace(shift_on(Shift(str(day), WHOLE_DAY), day, zone, until), name=str(day))


def last_begun(shift: Shift, zone: tzinfo | None, until: float) -> date | None:
    """Return the day on which a shift has begun last; None: on no day of the last week.

    :param until: now, seconds since the epoch
    """
    today = datetime.fromtimestamp(until, zone).date()
    for day in (today - timedelta(days=back) for back in range(_LOOK_BACK_DAYS)):
        if day.weekday() in shift.days and _span(shift.hours, day, zone)[0] < us_of(until):
            return day
    return None


def today(shifts: Shifts | None, now: float) -> date:
    """Return the day that the clock of the plant shows.

    :param now: seconds since the epoch
    """
    return datetime.fromtimestamp(now, None if shifts is None else zone_of(shifts)).date()


def day_columns(
    shifts: Shifts | None, last: date, count: int, now: float
) -> list[tuple[str, Period]]:
    """Return days in a row, each with a short title.

    :param shifts: what of them is planned; None: all
    :param last: the day of the last column
    :param now: seconds since the epoch; a day is as long as it has gone
    """
    zone = None if shifts is None else zone_of(shifts)
    columns = []
    for day in _days_to(last, count):
        period = day_on(day, zone, now)
        title = f'{day:%a %m-%d}'
        columns.append((title, period if shifts is None else planned_by(shifts, period)))
    return columns


def shift_columns(shifts: Shifts, last: date, count: int, now: float) -> list[tuple[str, Period]]:
    """Return the shifts of days in a row that have begun, each with a short title."""
    turns = turns_on(shifts, _days_to(last, count), zone_of(shifts))
    begun = [turn for turn in turns if turn.period.begin_us < us_of(now)]
    return [
        (
            f'{turn.shift} {turn.day:%m-%d}',
            replace(turn.period, end_us=min(turn.period.end_us, us_of(now))),
        )
        for turn in sorted(begun, key=lambda turn: turn.period.begin_us)
    ]


def _days_to(last: date, count: int) -> list[date]:
    return [last - timedelta(days=back) for back in reversed(range(count))]


def planned_by(shifts: Shifts, period: Period) -> Period:
    """Return a period with the planned time of shifts, and their targets."""
    planned = planned_within(shifts, *period.on_clock)
    if period.steady is not None:
        planned = Planned.of(period.steady.when_shown(planned.pieces))
    breaks = changed_breaks(shifts, *period.on_clock)
    return replace(wanted_by(shifts, period), planned=planned, zone=zone_of(shifts), breaks=breaks)


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


def changed_breaks(shifts: Shifts, begin: int, end: int) -> tuple[ChangedBreak, ...]:
    """Return the breaks between two moments in which the clocks change."""
    zone = zone_of(shifts)
    return tuple(
        pause
        for day in _days(begin, end, zone)
        for shift in shifts.shifts.values()
        if day.weekday() in shift.days
        for pause in _changed(shift, day, zone)
    )


def _days(begin: int, end: int, zone: tzinfo | None) -> Iterator[date]:
    """Yield the days on which a shift may begin that touches a period."""
    day = datetime.fromtimestamp(begin / US, zone).date() - timedelta(days=1)
    last = datetime.fromtimestamp(end / US, zone).date()
    while day <= last:
        yield day
        day += timedelta(days=1)


def _planned(shift: Shift, day: date, zone: tzinfo | None) -> Planned:
    off = [span for _, span in _breaks(shift, day, zone)]
    return Planned.of([_span(shift.hours, day, zone)], off)


def _changed(shift: Shift, day: date, zone: tzinfo | None) -> tuple[ChangedBreak, ...]:
    breaks = (
        ChangedBreak(shift.name, begin, end, pause.minutes * 60 * US)
        for pause, (begin, end) in _breaks(shift, day, zone)
    )
    return tuple(pause for pause in breaks if pause.took_us != pause.usual_us)


def _breaks(
    shift: Shift, day: date, zone: tzinfo | None
) -> Iterator[tuple[Hours, tuple[int, int]]]:
    """Yield the breaks with their begin and end."""
    for pause in shift.breaks:
        is_later = pause.begin_min < shift.hours.begin_min
        yield pause, _span(pause, day + timedelta(days=is_later), zone)


def _span(hours: Hours, day: date, zone: tzinfo | None) -> tuple[int, int]:
    """Return the begin and end of hours; a day on which clocks change is longer or shorter."""
    begin_us = _moment(day, hours.begin_min, zone)
    days, minute = divmod(hours.begin_min + hours.minutes, 24 * 60)
    return begin_us, _moment(day + timedelta(days=days), minute, zone)


def _moment(day: date, minute: int, zone: tzinfo | None) -> int:
    at = datetime.combine(day, time(minute // 60, minute % 60), zone)
    return us_of(at.timestamp())
