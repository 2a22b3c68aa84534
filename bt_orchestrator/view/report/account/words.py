"""How figures of an account are written for people, and what is said of its clock."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from typing import Any

from bt_orchestrator.view.report.account.period import ChangedBreak, Period
from bt_orchestrator.view.report.account.planned import US
from bt_orchestrator.view.report.account.steady_time import Step

UNKNOWN = '-'


def duration(us: Fraction | int) -> str:
    """Write a duration: hours, minutes and seconds; a short one with a decimal."""
    sign, us = ('-', -us) if us < 0 else ('', us)
    if us < 60 * US:
        return f'{sign}{float(us) / US:.1f} s'
    minutes, seconds = divmod(round(us / US), 60)
    hours, minutes = divmod(minutes, 60)
    return f'{sign}{hours}:{minutes:02}:{seconds:02}'


def is_seen(us: Fraction | int) -> bool:
    """Tell whether a duration is not written as 0.0 s: the node itself needs such moments."""
    return not -US < us * 20 < US


def percent(ratio: Fraction | None) -> str:
    """Write a ratio."""
    return UNKNOWN if ratio is None else f'{float(ratio) * 100:.1f} %'


def rate(per_item_us: Fraction | None) -> str:
    """Write a time for one item, and how many that are in an hour."""
    if not per_item_us:
        return UNKNOWN
    return f'{float(per_item_us) / US:.1f} s an item, {float(3600 * US / per_item_us):.1f} an hour'


# Sentences about a clock that was set, and about breaks on days on which the clocks change.


def step_words(step: Step, period: Period) -> str:
    """Say that the clock was set, and what that means for the figures."""
    return _step_words(step, period, _MEANS)


def old_step_words(step: Step, period: Period) -> str:
    """Say the same where books of the version before count otherwise."""
    return _step_words(step, period, _OLD_BOOKS)


def _step_words(step: Step, period: Period, means: Mapping[str, str]) -> str:
    before, after = map(_by_the_clock(period).when, step.times_us)
    way = 'back' if step.by_us < 0 else 'forward'
    by = f'{abs(step.by_us) / US:.0f} s'
    return f'the clock was set {way} by {by}, from {before} to {after}: {means[way]}'


_MEANS = {
    'back': 'the time that it showed twice passed twice, and counts twice',
    'forward': 'the time that it skipped did not pass, and does not count',
}
_OLD_BOOKS = {
    'back': 'the books of that time are of an older program, so the figures lack the time that '
    'came twice',
    'forward': 'the books of that time are of an older program: the skipped time counts as not '
    'recorded',
}


def break_words(pause: ChangedBreak, period: Period) -> str:
    """Say how long a break was."""
    begin, end = (_by_the_clock(period).when(us)[:-3] for us in (pause.begin_us, pause.end_us))
    way = 'back' if pause.took_us > pause.usual_us else 'forward'
    took = duration(pause.took_us) if pause.took_us else 'no time'
    return (
        f'the break of shift {pause.shift} from {begin} to {end} took {took} instead of '
        f'{duration(pause.usual_us)}: the clocks went {way} in it'
    )


def clock_plain(period: Period, steps: tuple[Step, ...]) -> dict[str, list[dict[str, Any]]]:
    """Return both for a program; nothing if there is nothing to tell."""
    iso = _by_the_clock(period).iso
    changes = {
        'clock_set': [
            {'seconds': step.by_us / US, 'from': iso(before), 'to': iso(after)}
            for step in steps
            for before, after in [step.times_us]
        ],
        'changed_breaks': [
            {
                'shift': pause.shift,
                'from': iso(pause.begin_us),
                'to': iso(pause.end_us),
                'seconds': pause.took_us / US,
                'usual_seconds': pause.usual_us / US,
            }
            for pause in period.changed_breaks
        ],
    }
    return {name: records for name, records in changes.items() if records}


def _by_the_clock(period: Period) -> Period:
    return replace(period, steady=None)
