"""An account as one file of HTML that needs nothing else: no script, no font, no address."""

from __future__ import annotations

from fractions import Fraction

from bt_orchestrator.view.drawing.account.tables import (
    classes,
    failing,
    flaws,
    holds,
    line_stops,
    made,
    measured,
    reasons,
    repairs,
    stops,
    waterfall,
)
from bt_orchestrator.view.drawing.documents.html import Html, document, program
from bt_orchestrator.view.drawing.wording import ENGLISH, Wording
from bt_orchestrator.view.report.account.account import Account
from bt_orchestrator.view.report.account.figures import Figures
from bt_orchestrator.view.report.account.words import UNKNOWN, duration, percent, rate

TIMES = '\N{MULTIPLICATION SIGN}'

PRODUCT = f'availability {TIMES} performance {TIMES} quality'

DEFINITIONS = (
    f'OEE = {PRODUCT}, after ISO 22400-2. '
    'Availability: actual production time of planned busy time. '
    'Performance: produced items at the pace of their scripts, of the actual production time. '
    'Quality: good items of produced ones. '
    'MTBF: time in which goals of the component were in flight, for each of its failures; '
    'MTTR: time that is booked to these failures.'
)


def account_page(account: Account, words: Wording = ENGLISH) -> str:
    """Return the page."""
    return document(title_of(account, words), lambda page: _write(page, account), STYLE, words)


def title_of(account: Account, words: Wording) -> str:
    """Return the title of a page: its period and its cell."""
    cell = account.figures.times.cell
    return ', '.join(filter(None, (words.report(account.period.name), cell)))


def _write(page: Html, account: Account) -> None:
    sheet = page.add('article', class_='account')
    shown = account.figures
    _head(sheet, account)
    _tiles(sheet, account)
    _facts(sheet, shown)
    waterfall(sheet, shown)
    stops(sheet, shown)
    classes(sheet, shown)
    if account.tells_reasons:
        reasons(sheet, account)
        line_stops(sheet, account)
    holds(sheet, account)
    made(sheet, shown)
    flaws(sheet, shown)
    measured(sheet, shown)
    failing(sheet, shown)
    repairs(sheet, shown)
    foot = sheet.add('footer')
    for note in (*account.notes(), DEFINITIONS, program()):
        foot.add('p', note)


def _head(sheet: Html, account: Account) -> None:
    period, cell = account.period, account.figures.times.cell
    sheet.add('p', f'Report of cell {cell}' if cell else 'Report', class_='kind')
    heading(sheet, period.name)
    zone = f' ({period.zone})' if period.zone is not None else ''
    when = f'{period.when(period.begin_us)} to {period.when(period.end_us)}{zone}'
    sheet.add('p', when, class_='sub')


def heading(sheet: Html, name: str) -> None:
    """Write the name of a period as the heading."""
    words = sheet.words.report(name)
    sheet.quote('h1', words[:1].upper() + words[1:])


def _tiles(sheet: Html, account: Account) -> None:
    shown, times = account.figures, account.figures.times
    tiles = sheet.add('div', class_='tiles')
    goal = account.period.targets.get('oee')
    aim = PRODUCT if goal is None else f'{PRODUCT}; target {percent(goal)}'
    _tile(tiles, 'OEE', shown.oee, aim, 'tile first')
    up = f'{duration(times.production_us)} of {duration(times.busy_us)}'
    _tile(tiles, 'Availability', shown.availability, up)
    pace = f'{_seconds(shown.pace_us)} at the pace, {_seconds(shown.per_item_us)} taken'
    _tile(tiles, 'Performance', shown.performance, pace if shown.produced else '')
    _tile(tiles, 'Quality', shown.quality, f'{shown.good} of {shown.produced} good')


def _tile(tiles: Html, title: str, ratio: Fraction | None, about: str, kind: str = 'tile') -> None:
    tile = tiles.add('div', class_=kind)
    tile.add('span', title)
    tile.add('b', percent(ratio))
    tile.add('small', about)


def _seconds(us: Fraction | None) -> str:
    return UNKNOWN if us is None else duration(us)


def _facts(sheet: Html, shown: Figures) -> None:
    outside = sum(job.outside for job in shown.times.made)
    bad = shown.produced - shown.good
    counts = f'{shown.produced}: {shown.good} good, {bad} not'
    passed = shown.first_pass
    facts = {
        'made': f'{counts}; {outside} more outside planned time' if outside else counts,
        'first pass': ''
        if passed is None or not shown.produced
        else f'{passed} good, first-pass yield {percent(shown.first_pass_yield)}',
        'rate': rate(shown.per_item_us) if shown.produced else '',
        'pace': rate(shown.pace_us) if shown.pace_us else '',
    }
    listed = sheet.add('dl', class_='facts')
    for name, value in facts.items():
        if value:
            listed.add('dt', name)
            listed.add('dd', value)


# The style of the page of an account, beyond the style of all documents.
#
# Bars have colours by what they count against; what they mean stands beside them in words.

STYLE = """
.account .tiles { grid-template-columns: 1.5fr repeat(3, 1fr) }
.account .tile span, .account .tile small { display: block; color: var(--quiet); font-size: .87em }
.account .tile b { font-size: 26px }
.account .tile.first b { font-size: 40px; line-height: 1.1 }
.account td { padding-top: 4px; padding-bottom: 4px; overflow-wrap: anywhere }
.account td.number, .account td.time { overflow-wrap: normal }
.account td small { display: block; color: var(--quiet); font-size: .87em }
.account td.number + td:not(.number) { padding-left: 8px }
.account td:last-child, .account th:last-child { padding-right: 0 }
.account .bar { width: 42% }
.account .bar svg { display: block; width: 100%; height: 15px; margin-top: 3px }
.account .is-left td { font-weight: 600; background: var(--panel) }
.account .is-left td:first-child { padding-left: 8px }
.account .is-loss td:first-child { padding-left: 24px }
.account .is-part td:first-child { padding-left: 48px }
.account .is-part td { color: var(--quiet) }
.account .is-left rect { fill: var(--bar) }
.account .not-busy rect { fill: var(--strong) }
.account .availability rect { fill: var(--bad) }
.account .performance rect { fill: var(--warn) }
.account .quality rect, .account .count rect { fill: var(--note) }
.account .scroll { overflow-x: auto }
.account footer p { margin: 3px 0 }
@media screen and (max-width: 720px) {
  .account .tiles { grid-template-columns: repeat(3, 1fr) }
  .account .tile.first { grid-column: 1 / -1 }
  .account .tile { padding: 8px 10px }
  .account .tile b { font-size: 19px }
  .account .tile.first b { font-size: 34px }
  .account table { font-size: 14px }
  .account .bar { width: 26% }
  .account td, .account th { padding-right: 7px }
  .account .is-loss td:first-child { padding-left: 14px }
}
@media print {
  .account .scroll { overflow: visible }
  .account .whole { break-inside: avoid }
}
"""
