"""Moments as users write them: a date and a time with its time zone (ISO 8601, RFC 3339)."""

from __future__ import annotations

import re
from datetime import datetime, timedelta, timezone

from bt_orchestrator.model.words import sentence
from bt_orchestrator.script.field_types import Misfit

INSTANT_FORM = (
    r'([0-9]{4})-([0-9]{2})-([0-9]{2})[Tt ]([0-9]{2}):([0-9]{2})(?::([0-9]{2})(?:[.]([0-9]+))?)?'
    r' ?([Zz]|([+-])([0-9]{2}):?([0-9]{2})?)'
)

END_S = 2.0**31
"""In January 2038: messages of ROS 2 carry seconds as 32 bit numbers."""

_NEEDED = sentence('a_moment')
_WITHOUT_TIME = '[0-9]{4}-[0-9]{2}-[0-9]{2}'
_ZONE = 'Z'


def instant(text: str) -> float | Misfit:
    """Return the seconds since the epoch that a text means, or why it is no moment."""
    match = re.fullmatch(INSTANT_FORM, text)
    if match is None:
        return Misfit(_NEEDED, _hint(text))
    try:
        seconds = _moment(match).timestamp()
    except (OverflowError, ValueError):
        return Misfit(sentence('a_real_moment'), sentence('its_numbers'))
    return out_of_range(seconds) or seconds


def out_of_range(seconds: float) -> Misfit | None:
    """Say why a time cannot be that of an order; None: it can."""
    if 0.0 < seconds < END_S:
        return None
    return Misfit(sentence('a_year'), sentence('years_why'))


def _moment(match: re.Match[str]) -> datetime:
    year, month, day, hour, minute = (int(match[number]) for number in range(1, 6))
    second, fraction = int(match[6] or 0), (match[7] or '')[:6].ljust(6, '0')
    return datetime(year, month, day, hour, minute, second, int(fraction), _zone(match))


def _zone(match: re.Match[str]) -> timezone:
    if match[9] is None:
        return timezone.utc
    minutes = int(match[11] or 0)
    if minutes > 59:
        raise ValueError('an hour has 60 minutes')
    offset = timedelta(hours=int(match[10]), minutes=minutes)
    return timezone(-offset if match[9] == '-' else offset)


def _hint(text: str) -> str:
    """Say what is missing, with the text that was written where that is possible."""
    if re.fullmatch(INSTANT_FORM, text + _ZONE):
        return sentence('add_zone', text=text)
    if re.fullmatch(_WITHOUT_TIME, text):
        return sentence('add_time', text=text)
    return sentence('moment_form')
