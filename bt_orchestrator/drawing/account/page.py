"""An account as one file of HTML that needs nothing else: no script, no font, no address."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from bt_orchestrator.drawing.account.html import section, text
from bt_orchestrator.drawing.account.style import STYLE
from bt_orchestrator.drawing.account.tables import (
    failing,
    holds,
    made,
    repairs,
    stops,
    waterfall,
)
from bt_orchestrator.report.account.account import Account
from bt_orchestrator.report.account.figures import Figures
from bt_orchestrator.report.account.words import UNKNOWN, duration, percent, rate

TIMES = '\N{MULTIPLICATION SIGN}'

PRODUCT = f'availability {TIMES} performance {TIMES} quality'

DEFINITIONS = (
    f'OEE = {PRODUCT}, after ISO 22400-2. '
    'Availability: actual production time of planned busy time. '
    'Performance: produced items at the pace of their scripts, of the actual production time. '
    'Quality: good items of produced ones. '
    'MTBF: planned busy time without repairs, for each failure; MTTR: from a hold to its release.'
)


def account_page(account: Account) -> str:
    """Return the page."""
    return '\n'.join(_lines(account)) + '\n'


def _lines(account: Account) -> Iterator[str]:
    shown = account.figures
    title = ', '.join(filter(None, (account.period.name, shown.times.cell)))
    yield '<!DOCTYPE html>'
    yield '<html lang="en"><head><meta charset="utf-8">'
    yield '<meta name="viewport" content="width=device-width, initial-scale=1">'
    yield f'<title>{text(title)}</title>'
    yield f'<style>{STYLE}</style></head><body>'
    yield from _head(account)
    yield from _tiles(shown)
    yield from _facts(shown)
    yield from section('Where the time went', waterfall(shown), 'whole')
    yield from section('Stops', stops(shown))
    yield from section('Holds', holds(account))
    yield from section('What was made', made(shown))
    yield from section('Failed attempts', failing(shown))
    yield from section('Components that failed', repairs(shown))
    yield '<footer>'
    yield from (f'<p>{text(note)}</p>' for note in (*account.notes(), DEFINITIONS))
    yield '</footer></body></html>'


def _head(account: Account) -> Iterator[str]:
    period, cell = account.period, account.figures.times.cell
    name = period.name[:1].upper() + period.name[1:]
    yield f'<header><h1>{text(name)}</h1>'
    zone = f' ({period.zone})' if period.zone is not None else ''
    when = f'{period.when(period.begin_us)} to {period.when(period.end_us)}{zone}'
    of_cell = f'Cell {cell}, ' if cell else ''
    yield f'<p>{text(of_cell + when)}</p></header>'


def _tiles(shown: Figures) -> Iterator[str]:
    times = shown.times
    yield '<div class="tiles">'
    yield from _tile('OEE', shown.oee, PRODUCT, 'first')
    up = f'{duration(times.production_us)} of {duration(times.busy_us)}'
    yield from _tile('Availability', shown.availability, up)
    pace = f'{_seconds(shown.pace_us)} at the pace, {_seconds(shown.per_item_us)} taken'
    yield from _tile('Performance', shown.performance, pace if shown.produced else '')
    yield from _tile('Quality', shown.quality, f'{shown.good} of {shown.produced} good')
    yield '</div>'


def _tile(title: str, ratio: Fraction | None, about: str, kind: str = '') -> Iterator[str]:
    yield f'<div class="{" ".join(filter(None, ("tile", kind)))}"><span>{title}</span>'
    yield f'<b>{percent(ratio)}</b><small>{text(about)}</small></div>'


def _seconds(us: Fraction | None) -> str:
    return UNKNOWN if us is None else duration(us)


def _facts(shown: Figures) -> Iterator[str]:
    outside = sum(one.outside for one in shown.times.made)
    facts = {
        'made': str(shown.produced),
        'good': str(shown.good),
        'not good': str(shown.produced - shown.good),
        'outside planned time': str(outside) if outside else '',
        'rate': rate(shown.per_item_us) if shown.produced else '',
        'pace': rate(shown.pace_us) if shown.pace_us else '',
    }
    yield '<dl class="facts">'
    for name, value in facts.items():
        if value:
            yield f'<div><dt>{name}</dt><dd>{value}</dd></div>'
    yield '</dl>'
