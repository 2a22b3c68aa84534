"""The tables of the page: the waterfall and the Paretos with their bars, and what stands below.

A part that has nothing to say is left out.
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from typing import NamedTuple

from bt_orchestrator.view.drawing.documents.html import Html
from bt_orchestrator.view.drawing.svg import Svg
from bt_orchestrator.view.report.account.account import Account
from bt_orchestrator.view.report.account.causes.flaws import (
    EFFECTS,
    MEASURED_TITLES,
    flaw_words,
    measured_name,
    measured_texts,
)
from bt_orchestrator.view.report.account.figures import Bar, Figures
from bt_orchestrator.view.report.account.losses import PARTS, WORDS, Step
from bt_orchestrator.view.report.account.period import Period
from bt_orchestrator.view.report.account.stops import Held
from bt_orchestrator.view.report.account.text import parts_of
from bt_orchestrator.view.report.account.words import UNKNOWN, duration, is_seen, percent
from bt_orchestrator.view.report.line_stops import shares


class Column(NamedTuple):
    """A column of a table."""

    title: str
    kind: str = ''
    """Class of its cells: number, time, bar or name; empty: words."""


class TableCell(NamedTuple):
    """The content of a row and a column."""

    text: str
    more: str = ''
    """A second line."""
    drawing: str = ''
    """SVG; in place of a text."""
    said: str = ''
    """A second line with what a person said, or with a name."""


MOST_LINE_STOPS = 40
"""Stops that are listed one by one: two sheets of paper are enough."""

BAR = Column('', 'bar')
NAME = 'name'
"""Kind of a column with names, which are the same in every language."""


def waterfall(sheet: Html, shown: Figures) -> None:
    """Write from the planned time over every loss to what is left at the end."""
    numbers = _numbers('time', 'of planned')
    body = add_table(sheet, 'Where the time went', (Column(''), BAR, *numbers), 'whole')
    left = Fraction(0)
    for step in shown.steps_seen():
        begin, left = (left, left - step.us) if step.loss else (Fraction(0), step.us)
        drawn = TableCell(
            '', drawing=bar(*(shown.of_planned(us) or Fraction(0) for us in (begin, left)))
        )
        cells = (TableCell(_signed(step)), TableCell(percent(shown.of_planned(step.us))))
        columns = (Column(''), BAR, *numbers)
        add_row(body, (TableCell(step.title), drawn, *cells), columns, _kind(step))
        for title, us in parts_of(shown, step.loss):
            texts = (duration(us), percent(shown.of_planned(us)))
            add_row(body, map(TableCell, (title, '', *texts)), columns, 'is-part')


def _kind(step: Bar) -> str:
    return f'is-loss {_step(WORDS[step.loss].step)}' if step.loss else 'is-left'


def _step(step: Step) -> str:
    return step.value.replace(' ', '-')


def _signed(step: Bar) -> str:
    minus = '\N{MINUS SIGN}' if step.loss and step.us >= 0 else ''
    return f'{minus}{duration(abs(step.us))}'


def stops(sheet: Html, shown: Figures) -> None:
    """Write the Pareto of the stops: how long, how often, the share of them and all above."""
    pareto = [stop for stop in shown.times.stops if stop.is_shown]
    if not pareto:
        return
    columns = (Column(''), BAR, *_numbers('time', 'times', 'so far'))
    body = add_table(sheet, 'Stops', columns)
    whole, so_far = sum(entry.us for entry in pareto), 0
    for entry in pareto:
        so_far += entry.us
        part = PARTS[entry.part].title if entry.part in PARTS else ''
        title = ', '.join(filter(None, (WORDS[entry.loss].title, part)))
        name = TableCell(title, entry.about)
        drawn = TableCell('', drawing=bar(0, Fraction(entry.us, pareto[0].us)))
        texts = (duration(entry.us), str(entry.times), percent(Fraction(so_far, whole)))
        add_row(body, (name, drawn, *map(TableCell, texts)), columns, _step(Step.AVAILABILITY))


def classes(sheet: Html, shown: Figures) -> None:
    """Write the micro-stops and the breakdowns among the own faults."""
    micro, breakdowns = shown.micro_stops(), shown.breakdowns()
    if not is_seen(micro.us + breakdowns.us):
        return
    columns = (Column(''), *_numbers('times', 'time'))
    body = add_table(sheet, 'Own fault by length', columns)
    limit = f'shorter than {duration(shown.micro_stop_us)}'
    for name, stop_class in (
        (TableCell('micro-stops', limit), micro),
        (TableCell('breakdowns'), breakdowns),
    ):
        add_row(
            body,
            (name, *map(TableCell, (str(stop_class.times), duration(stop_class.us)))),
            columns,
        )


def reasons(sheet: Html, account: Account) -> None:
    """Write the Pareto of the reasons of stops."""
    shown, period = account.figures, account.period
    columns = (Column('', NAME), BAR, *_numbers('time', 'times', 'of all'))
    title = f'Stops by reason, {percent(shown.not_classified)} of their time not classified'
    pareto = shares(shown.times.by_reason)
    body = add_table(sheet, title, columns)
    for share in pareto:
        reason = period.reasons.get(share.code)
        more = f'{share.code} {reason.group}'.strip() if reason is not None else ''
        name = TableCell(reason_words(body, period, share.code), said=more)
        drawn = TableCell('', drawing=bar(0, Fraction(share.us, pareto[0].us)))
        texts = (duration(share.us), str(share.times), percent(shown.of_stops(share.us)))
        kind = 'not-busy' if not share.code else _step(Step.AVAILABILITY)
        add_row(body, (name, drawn, *map(TableCell, texts)), columns, kind)


def reason_words(sheet: Html, period: Period, code: str) -> str:
    """Say a reason of the plant in the language of the page."""
    words = period.reason_words(code, sheet.words.language)
    return words if code else sheet.words.report(words)


def line_stops(sheet: Html, account: Account) -> None:
    """Write the longest stops one by one, in their order, with their reasons."""
    period = account.period
    when = (Column('from', 'time'), Column('to', 'time'))
    columns = (*when, Column('time', 'number'), Column('what'), Column('reason', NAME))
    body = add_table(sheet, 'Stops one by one', columns)
    longest = sorted(account.figures.times.line_stops, key=lambda stop: -stop.us)[:MOST_LINE_STOPS]
    for stop in sorted(longest, key=lambda stop: stop.span.since_us):
        span, reason = stop.span, stop.reason
        who = reason.who if reason is not None else ''
        by = body.words.report(f'by {who}') if who else ''
        note = ': '.join(filter(None, (by, reason.why if reason is not None else '')))
        cells = (
            TableCell(period.clock(span.since_us)),
            TableCell(period.clock(span.until_us)),
            TableCell(duration(stop.us)),
            TableCell(stop.about, f'stop {span.seq}'),
            TableCell(
                reason_words(body, period, '' if reason is None else reason.code), said=note
            ),
        )
        add_row(body, cells, columns)


def holds(sheet: Html, account: Account) -> None:
    """Write the holds in their order, with what was answered."""
    times = account.figures.times
    if times.holds:
        when = (Column('from', 'time'), Column('to', 'time'))
        columns = (*when, Column('lost', 'number'), Column('what'), Column('answer'))
        body = add_table(sheet, 'Holds', columns)
        for held in times.holds:
            add_row(body, _hold(account, held), columns)
    if times.holds_left_out:
        us = sum(times.left_out_us.values())
        sheet.add('p', f'and {times.holds_left_out} others, {duration(us)} together')


def _hold(account: Account, held: Held) -> tuple[TableCell, ...]:
    end = 'stands' if held.released_us is None else account.period.clock(held.released_us)
    return (
        TableCell(account.period.clock(held.raised_us)),
        TableCell(end),
        TableCell(duration(held.lost_us) if held.lost_us else UNKNOWN),
        TableCell(held.words, WORDS[held.loss].title if held.loss else ''),
        TableCell(f'{held.answer} by {held.who}' if held.answer else UNKNOWN, said=held.reason),
    )


def made(sheet: Html, shown: Figures) -> None:
    """Write the jobs whose items left the line."""
    if not shown.times.made:
        return
    titles = ('pace', 'good', 'nonconforming', 'rejected', 'by hand', 'outside')
    columns = (Column('job', NAME), Column('script', NAME), *_numbers(*titles))
    body = add_table(sheet, 'What was made', columns)
    for job in shown.times.made:
        pace = shown.paces.get(job.digest)
        recipe = f'recipe {job.recipe}' if job.recipe else ''
        counts = (job.good, job.nonconforming, job.rejected, job.by_hand, job.outside)
        texts = (UNKNOWN if pace is None else f'{pace.per_item_s:.1f} s', *map(str, counts))
        add_row(
            body,
            (TableCell(job.job), TableCell(job.script, recipe), *map(TableCell, texts)),
            columns,
        )


def flaws(sheet: Html, shown: Figures) -> None:
    """Write the Pareto of the causes of scrap, then that of rework."""
    for title, is_scrap in (('Not good, by cause', True), ('Done again, by cause', False)):
        pareto = [flaw for flaw in shown.times.flaws if flaw.of.effect.is_scrap is is_scrap]
        if not pareto:
            continue
        columns = (Column(''), BAR, *_numbers('times', 'so far'))
        body = add_table(sheet, title, columns)
        whole, so_far = sum(flaw.times for flaw in pareto), 0
        for flaw in pareto:
            so_far += flaw.times
            named = ', '.join(filter(None, (EFFECTS[flaw.of.effect], flaw.of.product)))
            drawn = TableCell('', drawing=bar(0, Fraction(flaw.times, pareto[0].times)))
            texts = (str(flaw.times), percent(Fraction(so_far, whole)))
            name = TableCell(named, flaw_words(flaw.of))
            kind = _step(Step.QUALITY if is_scrap else Step.PERFORMANCE)
            add_row(body, (name, drawn, *map(TableCell, texts)), columns, kind)


def measured(sheet: Html, shown: Figures) -> None:
    """Write the measured values of verdicts beside their bounds."""
    if not shown.times.measured:
        return
    columns = (Column('value', NAME), *_numbers(*MEASURED_TITLES))
    body = add_table(sheet, 'Measured values beside their bounds', columns)
    for measurement in shown.times.measured:
        name = TableCell(measured_name(measurement), said=measurement.of.product)
        add_row(body, (name, *map(TableCell, measured_texts(measurement))), columns)


def failing(sheet: Html, shown: Figures) -> None:
    """Write the Pareto of the attempts that failed."""
    pareto = shown.times.failing
    if not pareto:
        return
    columns = (Column(''), BAR, *_numbers('times', 'took'))
    body = add_table(sheet, 'Failed attempts', columns)
    for failure in pareto:
        name = TableCell(failure.component or 'nothing sent', f'{failure.task}: {failure.reason}')
        drawn = TableCell('', drawing=bar(0, Fraction(failure.times, pareto[0].times)))
        numbers = (TableCell(str(failure.times)), TableCell(duration(failure.us)))
        add_row(body, (name, drawn, *numbers), columns, 'count')


def repairs(sheet: Html, shown: Figures) -> None:
    """Write the components that failed, with the means of their times."""
    if not shown.times.repairs:
        return
    columns = (Column('component', NAME), *_numbers('failures', 'down', 'MTBF', 'MTTR'))
    body = add_table(sheet, 'Components that failed', columns)
    for repair in shown.times.repairs:
        between = shown.mtbf_us(repair)
        texts = (
            repair.component,
            str(repair.failures),
            duration(repair.down_us),
            UNKNOWN if between is None else duration(between),
            duration(shown.mttr_us(repair)),
        )
        add_row(body, map(TableCell, texts), columns)


# --- tables -----------------------------------------------------------------------------------


def _numbers(*titles: str) -> tuple[Column, ...]:
    return tuple(Column(title, 'number') for title in titles)


def add_table(
    sheet: Html, title: str, columns: Iterable[Column], kind: str = '', *, is_name: bool = False
) -> Html:
    """Begin a table below a heading, or a name; returns its body."""
    part = sheet.add('section', class_=kind)
    (part.quote if is_name else part.add)('h2', title)
    table = part.add('div', class_='scroll').add('table')
    head = table.add('thead').add('tr')
    for column in columns:
        head.add('th', column.title, class_=column.kind)
    return table.add('tbody')


def add_row(
    body: Html, cells: Iterable[TableCell], columns: Iterable[Column], kind: str = ''
) -> None:
    """Write a row, as wide as its table."""
    row = body.add('tr', class_=kind)
    for cell, column in zip(cells, columns, strict=True):
        write = row.quote if column.kind == NAME else row.add
        place = write('td', cell.text, class_=column.kind)
        if cell.drawing:
            place.draw(cell.drawing)
        if cell.more:
            place.add('small', cell.more)
        if cell.said:
            place.quote('small', cell.said)


# Bars of the waterfall and of a Pareto, one a row of a table.

WIDTH, HEIGHT = 1000.0, 15.0
LEAST = 2.0
"""Width of what is there and would be too narrow to be seen."""


def bar(begin: Fraction | float, end: Fraction | float) -> str:
    """Draw a bar between two parts of the whole, in any order; it ends with the whole."""
    low, high = sorted(min(max(float(part), 0.0), 1.0) for part in (begin, end))
    drawing = Svg.part(WIDTH, HEIGHT)
    if high > low:
        width = max(LEAST, (high - low) * WIDTH)
        drawing.add('rect', x=min(low * WIDTH, WIDTH - LEAST), y=0, width=width, height=HEIGHT)
    return str(drawing)
