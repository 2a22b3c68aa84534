"""An account as CSV: one table of numbers, each with the part that it belongs to."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from typing import IO, Any, NamedTuple

from bt_orchestrator.view.report.account.account import Account
from bt_orchestrator.view.report.account.figures import LACKS, Lack
from bt_orchestrator.view.report.account.plain import account_plain
from bt_orchestrator.view.report.csv_export import csv_cell


class Row(NamedTuple):
    """One number, or a few that belong together."""

    part: str
    name: str
    component: str = ''
    detail: str = ''
    number: int | None = None
    seconds: float | None = None
    ratio: float | None = None


def write_csv(account: Account, file: IO[str]) -> None:
    """Write all rows; what is not known is empty."""
    rows = csv.writer(file)
    rows.writerow(Row._fields)
    for row in _rows(account_plain(account)):
        rows.writerow(map(csv_cell, row))


def _rows(plain: dict[str, Any]) -> Iterator[Row]:
    period = plain['period']
    yield Row('period', period['name'], detail=period['from'], seconds=period['planned_s'])
    yield from (Row('oee', name, ratio=ratio) for name, ratio in plain['oee'].items())
    yield from (Row('quantity', name, number=n) for name, n in plain['quantities'].items())
    yield from (Row('rate', name, seconds=seconds) for name, seconds in plain['rate'].items())
    if plain['lack'] is not None:
        yield Row('note', plain['lack'], detail=LACKS[Lack(plain['lack'])])
    for name in ('clock_set', 'changed_breaks'):
        for one in plain.get(name, ()):
            yield Row('note', name, detail=one['from'], seconds=one['seconds'])
    for bar in plain['waterfall']:
        part = 'loss' if bar['loss'] else 'time'
        name = bar['loss'] or bar['title']
        yield Row(part, name, detail=bar['title'], seconds=bar['seconds'])
    for job in plain['jobs']:
        yield from (Row('job', job['job'], detail=kind, number=job[kind]) for kind in _COUNTS)
    for one in plain['stops']:
        yield Row(
            'stop', one['loss'], one['component'], one['detail'], one['times'], one['seconds']
        )
    for one in plain['holds']:
        yield Row('hold', one['hold'], detail=one['words'], seconds=one['lost_s'])
    for one in plain['failed_attempts']:
        named = one['task'], one['component'], one['reason']
        yield Row('failed attempt', *named, one['times'], one['seconds'])
    for one in plain['components']:
        for name in ('mtbf_s', 'mttr_s'):
            yield Row('component', name[:-2], one['component'], '', one['failures'], one[name])


_COUNTS = ('good', 'nonconforming', 'rejected', 'by_hand', 'outside_planned_time')
