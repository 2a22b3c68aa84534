"""Finds the period that the options of the verb `report` mean."""

from __future__ import annotations

import argparse
import time
from dataclasses import replace
from datetime import date
from pathlib import Path

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.cli.numbers import add_period_options
from bt_orchestrator.cli.output import WrongUse
from bt_orchestrator.model.plant.shifts import DAYS, Shift, Shifts
from bt_orchestrator.script.report import did_you_mean, listing
from bt_orchestrator.script.shifts.shifts_file import read_reasons, read_shifts
from bt_orchestrator.view.report.account.account import of_job, whole
from bt_orchestrator.view.report.account.calendar import (
    day_columns,
    day_on,
    last_begun,
    planned_by,
    shift_columns,
    shift_on,
    today,
    wanted_by,
    zone_of,
)
from bt_orchestrator.view.report.account.period import Period
from bt_orchestrator.view.report.account.planned import us_of
from bt_orchestrator.view.report.reading import Reading

MOST_DAYS = 92
"""A quarter of a year: the most columns of a report."""


class NoShift(OrchestratorError):
    """There is no such shift, or not on that day."""


def add_which_options(parser: argparse.ArgumentParser) -> None:
    """Declare which period is meant; without any it is all that the journal has."""
    add_period_options(parser, 'the account of what happened')
    parser.add_argument('--job', metavar='JOB', help='from the start of this job to its end')
    parser.add_argument(
        '--shift', metavar='NAME', help='this shift; the one that began last, or see --day'
    )
    parser.add_argument(
        '--day',
        type=_day,
        metavar='DATE',
        help='with --shift: the one that began on this day; else this whole day; with --days: the '
        'last of them',
    )
    parser.add_argument(
        '--days',
        type=_days,
        metavar='N',
        help='side by side: the last N days, today as far as it has gone; with --shift: that '
        'shift on each of them',
    )
    parser.add_argument(
        '--each-shift',
        action='store_true',
        help='with --days: a column for each shift of the file in place of each day',
    )
    parser.add_argument(
        '--shifts',
        type=Path,
        metavar='FILE',
        help='file of shifts (YAML); without it all time counts as planned',
    )
    parser.add_argument(
        '--reasons',
        type=Path,
        metavar='FILE',
        help="file of the plant's reasons for stops (YAML): their words and groups; without it "
        'stops have the codes alone',
    )


def with_reasons(args: argparse.Namespace, period: Period) -> Period:
    """Return a period with the reasons of the plant, if their file is named.

    :raises Refused: the file has mistakes
    """
    if args.reasons is None:
        return period
    return replace(period, reasons=read_reasons(args.reasons))


def period_of(args: argparse.Namespace, reading: Reading) -> Period:
    """Return the period that the options name.

    :raises WrongUse: the options contradict each other
    :raises NoShift: there is no such shift
    :raises NothingToReport: the journal has nothing of it
    :raises Refused: the file of shifts has mistakes
    """
    _refuse_contradictions(args)
    shifts = None if args.shifts is None else read_shifts(args.shifts)
    if args.shift is not None:
        assert shifts is not None
        return with_reasons(args, _of_shift(args, shifts))
    period = _without_shift(args, reading, shifts)
    period = period if shifts is None else planned_by(shifts, period)
    return with_reasons(args, period)


def periods_of(args: argparse.Namespace) -> list[tuple[str, Period]]:
    """Return what `--days` names, with the reasons of the plant.

    :raises WrongUse: the options contradict each other
    :raises NoShift: there is no such shift, or none of them has begun
    :raises Refused: the file of shifts or of reasons has mistakes
    """
    return [(title, with_reasons(args, period)) for title, period in _days_of(args)]


def _days_of(args: argparse.Namespace) -> list[tuple[str, Period]]:
    """Return the days, or the shifts on them, that `--days` names: each with a short title.

    :raises WrongUse: the options contradict each other
    :raises NoShift: there is no such shift, or none of them has begun
    :raises Refused: the file of shifts has mistakes
    """
    _refuse_contradictions(args)
    shifts = None if args.shifts is None else read_shifts(args.shifts)
    now = time.time()
    last = args.day or today(shifts, now)
    if shifts is None or (args.shift is None and not args.each_shift):
        return day_columns(shifts, last, args.days, now)
    if args.shift is not None:
        shifts = replace(shifts, shifts={args.shift: _named(args, shifts)})
    begun = shift_columns(shifts, last, args.days, now)
    if not begun:
        raise NoShift(f'no shift of {args.shifts} has begun on the {args.days} days to {last}')
    return begun


def _refuse_contradictions(args: argparse.Namespace) -> None:
    named = {
        '--from or --to': args.since is not None or args.until is not None,
        '--job': args.job is not None,
        '--shift or --day': args.shift is not None or args.day is not None,
    }
    given = [name for name, is_given in named.items() if is_given]
    if len(given) > 1:
        raise WrongUse(f'{" and ".join(given)} name a period each; leave one of them out')
    if args.shift is not None and args.shifts is None:
        raise WrongUse('--shift needs the file in which the shifts are: --shifts FILE')
    if args.since is not None and args.until is not None and args.since >= args.until:
        raise WrongUse('--from has to be before --to; exchange them')
    _refuse_with_days(args, given)


def _refuse_with_days(args: argparse.Namespace, given: list[str]) -> None:
    if args.days is None:
        if args.each_shift:
            raise WrongUse(
                '--each-shift says what the columns are: --days N says of how many days'
            )
        return
    named = [name for name in given if name != '--shift or --day']
    if named:
        raise WrongUse(f'--days and {named[0]} name a period each; leave one of them out')
    if args.each_shift and args.shifts is None:
        raise WrongUse('--each-shift needs the file in which the shifts are: --shifts FILE')
    if args.each_shift and args.shift is not None:
        raise WrongUse('--each-shift is all shifts, --shift one of them; leave one of them out')


def _without_shift(args: argparse.Namespace, reading: Reading, shifts: Shifts | None) -> Period:
    journal = f'the journal {args.journal}'
    if args.job is not None:
        return of_job(reading, args.job, journal)
    if args.day is not None:
        zone = None if shifts is None else zone_of(shifts)
        return day_on(args.day, zone, time.time())
    known = whole(reading, journal)
    if args.since is None and args.until is None:
        return known
    first, last = known.on_clock
    begin = first if args.since is None else us_of(args.since)
    end = min(us_of(time.time()), last if args.until is None else us_of(args.until))
    return Period.all_planned('period', begin, end)


def _of_shift(args: argparse.Namespace, shifts: Shifts) -> Period:
    """Return the period of a shift.

    :raises NoShift: there is none of this name, or none on this day
    """
    shift = _named(args, shifts)
    zone, now = zone_of(shifts), time.time()
    day = last_begun(shift, zone, now) if args.day is None else args.day
    assert day is not None, 'a shift begins on some day of every week'
    if day.weekday() not in shift.days:
        days = ', '.join(DAYS[number] for number in shift.days)
        raise NoShift(f'shift {shift.name} does not begin on {day:%a} {day}, only on {days}')
    period = shift_on(shift, day, zone, now)
    if period.begin_us >= period.end_us:
        raise NoShift(f'shift {shift.name} of {day} has not begun yet')
    return wanted_by(shifts, period)


def _named(args: argparse.Namespace, shifts: Shifts) -> Shift:
    shift = shifts.shifts.get(args.shift)
    if shift is None:
        hint = did_you_mean(args.shift, shifts.shifts, f'it has {listing(shifts.shifts)}')
        raise NoShift(f'{args.shifts} has no shift {args.shift}; {hint}')
    return shift


def _days(text: str) -> int:
    if not text.isascii() or not text.isdecimal() or not 2 <= int(text[:4]) <= MOST_DAYS:
        raise argparse.ArgumentTypeError(
            f'expected a number of days from 2 to {MOST_DAYS}, found {text!r}; for one day there '
            'is --day'
        )
    return int(text)


def _day(text: str) -> date:
    try:
        return date.fromisoformat(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(f'{text!r} is not a day; write 2026-05-17') from error
