"""Accounts side by side as text for a terminal, as plain data, and as CSV."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from fractions import Fraction
from typing import IO, Any

from bt_orchestrator.view.report.account.losses import WORDS
from bt_orchestrator.view.report.account.named_figures import By, Unit
from bt_orchestrator.view.report.account.plain import held_plain, seconds_of, stop_plain
from bt_orchestrator.view.report.account.text import titled
from bt_orchestrator.view.report.account.words import UNKNOWN, duration, percent
from bt_orchestrator.view.report.beside import Beside, Column, Group, Largest, Row
from bt_orchestrator.view.report.csv_export import csv_cell
from bt_orchestrator.view.report.tables import table

MOST_CAUSES = 3
"""Stops and holds of each of the largest losses."""


def beside_text(report: Beside, by: By | None) -> Iterator[str]:
    """Yield the lines of a report with columns."""
    period, whole = report.together.period, report.together.figures
    cell = f'cell {whole.times.cell}, ' if whole.times.cell else ''
    yield f'{cell}{period.name}, {period.when(period.begin_us)} to {period.when(period.end_us)}'
    yield from (f'  {note}' for note in report.together.notes())
    yield ''
    if len(report.columns) == 1:
        yield from _one_column(report, by)
        return
    for number, group in enumerate(report.groups(by)):
        if number:
            yield ''
        rows = [texts(row, group) for row in group.rows]
        yield from table((group.name, *titles(report, group)), rows)
    if by is None:
        lines = list(judged(report))
        yield from ['', *lines] if lines else []
        yield from titled('largest losses', _largest(report))


def _one_column(report: Beside, by: By | None) -> Iterator[str]:
    """Yield a line for each product, job or component."""
    groups = report.groups(by)
    if not groups:
        yield 'no component failed' if by is By.COMPONENT else 'nothing was made'
        return
    titles = [row.title for row in groups[0].rows]
    rows = [
        (group.name, *(row.unit.words(row.together) or UNKNOWN for row in group.rows))
        for group in groups
    ]
    yield from table(('', *titles), rows)


def titles(report: Beside, group: Group) -> tuple[str, ...]:
    """Return the heads of a group's table, beside that of its first column."""
    target = ('target',) if group.has_targets else ()
    return (*(column.title for column in report.columns), 'together', 'trend', *target)


def texts(row: Row, group: Group) -> tuple[str, ...]:
    """Return a line of a group's table."""
    values = (row.unit.words(value) or UNKNOWN for value in (*row.values, row.together))
    target = (row.unit.words(row.target),) if group.has_targets else ()
    return (row.title, *values, row.unit.words(row.trend, signed=True), *target)


def judged(report: Beside) -> Iterator[str]:
    """Yield what stands out: targets, and the best and the worst column."""
    of = len(report.known)
    for row in report.groups(None)[0].rows:
        if row.target is not None:
            target = percent(row.target)
            yield f'{row.title} reached its target of {target} in {row.reached} of {of}'
    extremes = report.extremes()
    if extremes is not None:
        best, worst = (f'{extreme.title} ({percent(_first(extreme))})' for extreme in extremes)
        yield f'best {best}, worst {worst}'


def _first(column: Column) -> Fraction | None:
    assert column.account is not None
    shown = column.account.figures
    return shown.availability if shown.oee is None else shown.oee


def _largest(report: Beside) -> Iterator[str]:
    planned = report.together.figures.of_planned
    for loss in report.largest():
        share = percent(planned(loss.bar.us))
        yield f'{loss.bar.title}: {duration(loss.bar.us)}, {share} of planned time'
        yield from (f'  {line}' for line in causes(report, loss))


def causes(report: Beside, loss: Largest) -> Iterator[str]:
    """Yield what caused a loss: its stops, its holds, what was done, and what is open."""
    for stop in loss.stops[:MOST_CAUSES]:
        yield f'{duration(stop.us)} in {stop.times}: {stop.about or WORDS[stop.loss].title}'
    period = report.together.period
    for share in loss.reasons[:MOST_CAUSES]:
        yield f'reason {period.reason_words(share.code)}: {duration(share.us)} in {share.times}'
    for held in loss.holds[:MOST_CAUSES]:
        reason = f': {held.reason}' if held.reason else ''
        answer = f'{held.answer} by {held.who}{reason}' if held.answer else 'open'
        lost = f'{period.clock(held.raised_us)}, {duration(held.lost_us)} lost'
        yield f'{lost}, {held.words}; {answer}'


def beside_plain(report: Beside, by: By | None) -> dict[str, Any]:
    """Return the report as JSON carries it; times in seconds, null: not known."""
    extremes = report.extremes()
    best, worst = (None, None) if extremes is None else (extreme.title for extreme in extremes)
    period = report.together.period
    return {
        'cell': report.together.figures.times.cell or None,
        'by': None if by is None else by.value,
        'columns': [_column(column) for column in report.columns],
        'groups': [_group(group) for group in report.groups(by)],
        'best': best,
        'worst': worst,
        'largest_losses': [
            {
                'loss': loss.bar.loss.value,
                'seconds': seconds_of(loss.bar.us),
                'stops': [stop_plain(stop) for stop in loss.stops],
                'holds': [held_plain(held, period) for held in loss.holds],
                'reasons': [
                    {
                        'code': share.code or None,
                        'times': share.times,
                        'seconds': seconds_of(share.us),
                    }
                    for share in loss.reasons
                ],
            }
            for loss in report.largest()
            if loss.bar.loss is not None
        ],
        'notes': list(report.together.notes()),
    }


def _column(column: Column) -> dict[str, Any]:
    period = column.period
    return {
        'title': column.title,
        'name': period.name,
        'from': period.iso(period.begin_us),
        'to': period.iso(period.end_us),
        'planned_s': seconds_of(period.planned.total_us),
        'is_known': column.account is not None,
    }


def _group(group: Group) -> dict[str, Any]:
    return {'name': group.name or None, 'rows': [_row(row) for row in group.rows]}


def _row(row: Row) -> dict[str, Any]:
    unit = row.unit
    return {
        'name': row.name,
        'unit': unit.value,
        'values': [_number(unit, value) for value in row.values],
        'together': _number(unit, row.together),
        'trend': _number(unit, row.trend, is_change=True),
        'target': _number(unit, row.target),
    }


def _number(unit: Unit, value: Fraction | None, *, is_change: bool = False) -> float | int | None:
    if value is None:
        return None
    if unit is Unit.SECONDS:
        return seconds_of(value)
    return int(value) if unit is Unit.COUNT and not is_change else round(float(value), 6)


def write_beside_csv(report: Beside, by: By | None, file: IO[str]) -> None:
    """Write a line for each figure of each column, then those of all together."""
    rows = csv.writer(file)
    rows.writerow(('column', 'from', 'to', 'name', 'figure', 'unit', 'value'))
    for group in report.groups(by):
        for row in group.rows:
            for column, value in zip(report.columns, row.values, strict=True):
                when = column.period.iso
                span = (when(column.period.begin_us), when(column.period.end_us))
                rows.writerow(map(csv_cell, (column.title, *span, *_csv(group, row, value))))
            rows.writerow(map(csv_cell, ('together', '', '', *_csv(group, row, row.together))))


def _csv(group: Group, row: Row, value: Fraction | None) -> tuple[Any, ...]:
    return (group.name, row.name, row.unit.value, _number(row.unit, value))
