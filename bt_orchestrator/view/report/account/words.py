"""How figures of an account are written for people."""

from __future__ import annotations

from fractions import Fraction

from bt_orchestrator.view.report.account.planned import US

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
