"""Accounts side by side as one page of HTML: a week on one sheet of paper, for a meeting."""

from __future__ import annotations

from fractions import Fraction

from bt_orchestrator.view.drawing.account.page import DEFINITIONS, STYLE, heading, title_of
from bt_orchestrator.view.drawing.account.tables import (
    NAME,
    Column,
    TableCell,
    add_row,
    add_table,
    reason_words,
)
from bt_orchestrator.view.drawing.documents.html import Html, document, program
from bt_orchestrator.view.drawing.svg import Svg
from bt_orchestrator.view.drawing.wording import ENGLISH, Wording
from bt_orchestrator.view.report.account.losses import WORDS
from bt_orchestrator.view.report.account.named_figures import By
from bt_orchestrator.view.report.account.words import UNKNOWN, duration, percent
from bt_orchestrator.view.report.beside import Beside, Group, Largest, Row
from bt_orchestrator.view.report.beside_words import MOST_CAUSES, judged, texts, titles

CHART = (100.0, 56.0)

TREND = (
    'Trend: the change from one column to the next, as the median over all pairs of columns. '
    'Together: of all columns, from their sums.'
)

_WIDE = """
main { max-width: 1400px }
.beside td.number, .beside th.number { padding-left: 10px; padding-right: 0 }
.beside td:first-child { white-space: nowrap }
.beside .named h2 { text-transform: none; letter-spacing: 0; font-size: 15px; color: var(--ink) }
.beside .best { color: var(--good) } .beside .worst { color: var(--bad) }
.beside .chart td { padding: 0 0 0 10px; border: 0; vertical-align: bottom }
.beside .chart svg { display: block; width: 100%; height: 56px }
.beside .chart rect { fill: var(--bar) }
.beside .chart line { stroke: var(--ink); stroke-dasharray: 4 3; stroke-width: 2 }
.beside .losses { display: grid; grid-template-columns: repeat(auto-fit, minmax(290px, 1fr));
  gap: 0 28px }
.beside .losses li { margin: 0 0 6px; overflow-wrap: anywhere }
.beside .losses ul { padding-left: 18px; margin: 8px 0 0 }
.beside .losses small { display: block; color: var(--quiet) }
.beside .losses b.open { color: var(--bad) }
@media print {
  @page { size: A4 landscape; margin: 9mm 11mm }
  body { font-size: 7pt; line-height: 1.2 }
  h1 { font-size: 15pt } h2 { margin: 7pt 0 4pt; padding-bottom: 2pt }
  h3 { font-size: 8.5pt } footer { margin-top: 6pt; padding-top: 4pt; font-size: 6.5pt }
  .beside td, .beside th { padding-top: 0; padding-bottom: 0 }
  .beside th { font-size: 7pt }
  .beside h2 { font-size: 7pt; margin-top: 5pt }
  .beside .kind { font-size: 6.5pt }
  .beside .chart svg { height: 26px }
  .beside footer { margin-top: 3pt; padding-top: 2pt; font-size: 6pt }
  .beside footer p { display: inline } .beside footer p::after { content: " " }
  .beside .losses li { margin-bottom: 2px }
  .beside .losses section { break-inside: avoid }
}
"""


def beside_page(report: Beside, by: By | None, words: Wording = ENGLISH) -> str:
    """Return the page."""
    title = title_of(report.together, words)
    return document(title, lambda page: _write(page, report, by), STYLE + _WIDE, words)


def _write(page: Html, report: Beside, by: By | None) -> None:
    sheet = page.add('article', class_='account beside')
    period, cell = report.together.period, report.together.figures.times.cell
    sheet.add('p', f'Report of cell {cell}' if cell else 'Report', class_='kind')
    heading(sheet, period.name)
    if by is None:
        sheet.quote('p', '; '.join(map(sheet.words.report, judged(report))), class_='sub')
    groups = report.groups(by)
    if len(report.columns) == 1:
        _one_column(sheet, groups, by)
    else:
        for group in groups:
            _columns(sheet, report, group)
    if by is None:
        _losses(sheet, report)
    foot = sheet.add('footer')
    for note in (*report.together.notes(), TREND, DEFINITIONS, program()):
        foot.add('p', note)


def _one_column(sheet: Html, groups: tuple[Group, ...], by: By | None) -> None:
    if not groups or by is None:
        sheet.add('p', 'nothing to tell')
        return
    heads = (Column(by.value, NAME), *(Column(row.title, 'number') for row in groups[0].rows))
    body = add_table(sheet, f'By {by.value}', heads)
    for group in groups:
        texts = (row.unit.words(row.together) or UNKNOWN for row in group.rows)
        add_row(body, map(TableCell, (group.name, *texts)), heads)


def _columns(sheet: Html, report: Beside, group: Group) -> None:
    heads = (Column(''), *(Column(title, 'number') for title in titles(report, group)))
    kind = 'named' if group.name else ''
    body = add_table(sheet, group.name or 'Side by side', heads, kind, is_name=bool(group.name))
    if not group.name:
        _chart(body, group.rows[0] if group.rows[0].together is not None else group.rows[1])
    extremes = report.extremes()
    for row in group.rows:
        cells = map(TableCell, texts(row, group))
        kinds = list(heads)
        if row is group.rows[0] and not group.name and extremes is not None:
            for column, kind in zip(extremes, ('best', 'worst'), strict=True):
                at = report.columns.index(column) + 1
                kinds[at] = Column(heads[at].title, f'number {kind}')
        look = 'is-left' if row.name == 'oee' else 'is-part' if row.title.startswith(' ') else ''
        add_row(body, cells, kinds, look)


def _chart(body: Html, row: Row) -> None:
    """Draw the first figure of each column as a bar from below, with the target across."""
    cells = [
        TableCell(''),
        *(TableCell('', drawing=_bar(value, row.target)) for value in row.values),
    ]
    add_row(body, cells, [Column('')] * len(cells), 'chart')


def _bar(value: Fraction | None, target: Fraction | None) -> str:
    width, height = CHART
    drawing = Svg.part(width, height)
    if value is not None:
        part = min(float(value), 1.0) * height
        drawing.add('rect', x=width * 0.2, y=height - part, width=width * 0.6, height=part)
    if target is not None:
        at = height * (1 - float(target))
        drawing.add('line', x1=0, x2=width, y1=at, y2=at)
    return str(drawing)


def _losses(sheet: Html, report: Beside) -> None:
    losses = report.largest()
    if not losses:
        return
    sheet.add('h2', 'Largest losses')
    place = sheet.add('div', class_='losses')
    for loss in losses:
        part = place.add('section')
        share = percent(report.together.figures.of_planned(loss.bar.us))
        part.add('h3', f'{loss.bar.title}: {duration(loss.bar.us)}, {share} of planned time')
        _causes(part.add('ul'), report, loss)


def _causes(listed: Html, report: Beside, loss: Largest) -> None:
    for stop in loss.stops[:MOST_CAUSES]:
        words = stop.about or WORDS[stop.loss].title
        listed.add('li', f'{words}: {duration(stop.us)} in {stop.times}')
    period = report.together.period
    for share in loss.reasons[:MOST_CAUSES]:
        name = reason_words(listed, period, share.code)
        listed.add('li', f'reason {name}: {duration(share.us)} in {share.times}')
    clock = period.clock
    for held in loss.holds[:MOST_CAUSES]:
        line = listed.add('li', f'{clock(held.raised_us)}, {duration(held.lost_us)}: {held.words}')
        if held.answer:
            reason = f': {held.reason}' if held.reason else ''
            line.add('small', f'{held.answer} by {held.who}{reason}')
        else:
            line.add('b', 'open', class_='open')
