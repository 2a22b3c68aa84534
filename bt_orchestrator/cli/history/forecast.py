"""The option `--forecast` of the verb `history`: a job beside its forecast."""

from __future__ import annotations

import argparse
from pathlib import Path

from bt_orchestrator.cli import bootstrap
from bt_orchestrator.cli.history.chart import refuse_too_many
from bt_orchestrator.cli.output import WrongUse
from bt_orchestrator.model.codec import json_of
from bt_orchestrator.sim.looking_back import LookingBack, Watchers
from bt_orchestrator.view.drawing.gantt import End, GanttFold
from bt_orchestrator.view.drawing.gantt_page import gantt_svg
from bt_orchestrator.view.report.account.planned import US
from bt_orchestrator.view.report.reading import Reading
from bt_orchestrator.view.report.retrospect.retrospect import Retrospect
from bt_orchestrator.view.report.retrospect.text import (
    period_of,
    retrospect_plain,
    retrospect_text,
)

_NOT_WITH = (
    'script',
    'html',
    'record',
    'b2mml',
    'item',
    'items',
    'serial',
    'lot',
    'since',
    'until',
)


def add_forecast_options(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        '--forecast',
        action='store_true',
        help='with --job and --cell: the job beside its forecast, a virtual run from the moment '
        'at which it started; as text, with --json, or with --gantt as a chart of both',
    )
    parser.add_argument(
        '--cell',
        type=Path,
        metavar='CELL',
        help='with --forecast: the cell file as it was then (YAML), with the durations',
    )
    parser.add_argument(
        '--usual-durations',
        action='store_true',
        help='with --forecast: tasks take as long as they had taken before the job, as in the '
        'forecast of the node; without it the cell file says how long',
    )


def refuse_contradictions(args: argparse.Namespace) -> None:
    """Refuse options that do not belong together.

    :raises WrongUse: there are some
    """
    if not args.forecast:
        if args.cell is not None or args.usual_durations:
            raise WrongUse('--cell and --usual-durations are for a forecast: add --forecast')
        return
    if args.job is None or args.cell is None:
        raise WrongUse('--forecast compares one job, on its cell: --job JOB --cell CELL')
    if any(getattr(args, name) for name in _NOT_WITH):
        raise WrongUse('with --forecast go --json, --gantt and -o; leave the other options out')


def forecast_text(reading: Reading, args: argparse.Namespace) -> str:
    """Return what the options ask for.

    :raises NoForecast: there is nothing to compare the job with
    :raises NotKept: the journal does not have that moment any more, or it was another cell then
    :raises Refused: the cell file, with every mistake in it
    """
    types = bootstrap.installed_types()
    cell = bootstrap.load_cell(args.cell, types)
    looking = LookingBack(reading, cell, types, f'the journal {args.journal}')
    folds = [GanttFold(by_component=True) for _ in range(2)] if args.gantt else []
    watchers = Watchers(folds[:1], folds[1:])
    retrospect = looking.at(args.job, watchers, usual=args.usual_durations)
    if args.gantt:
        return _chart(retrospect, *folds)
    if args.json:
        return f'{json_of(retrospect_plain(retrospect))}\n'
    return ''.join(f'{line}\n' for line in retrospect_text(retrospect))


def _chart(retrospect: Retrospect, forecast: GanttFold, real: GanttFold) -> str:
    """Draw both, one row a component.

    :raises WrongUse: it is too much for one chart
    """
    assert retrospect.forecast.end_us is not None
    period = period_of(retrospect)
    ends = [End(period.shown_us(retrospect.forecast.end_us) / US, is_forecast=True)]
    if retrospect.real.end_us is not None:
        ends.append(End(period.shown_us(retrospect.real.end_us) / US, is_forecast=False))
    begin_s, until_s = (
        period.shown_us(time_us) / US
        for time_us in (retrospect.begin_us, retrospect.real.until_us)
    )
    end_s = max(ends[0].time_s, until_s)
    forecast.end(ends[0].time_s)
    if retrospect.real.end_us is None:
        real.end(until_s)
    expected, was = forecast.past(begin_s, end_s), real.past(begin_s, end_s)
    refuse_too_many(sum(len(row.tasks) for chart in (expected, was) for row in chart.rows))
    begin = period.when(retrospect.begin_us)
    title = f'job {retrospect.job} from {begin}: forecast, and what happened'
    return gantt_svg(was.under(expected, ends).named(title))
