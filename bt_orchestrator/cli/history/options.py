"""The options of the verb `history`."""

from __future__ import annotations

import argparse
from pathlib import Path

from bt_orchestrator.cli.here import add_journal_option
from bt_orchestrator.cli.history import forecast
from bt_orchestrator.cli.history.forecast import add_forecast_options
from bt_orchestrator.cli.numbers import add_period_options
from bt_orchestrator.cli.output import WrongUse

DESCRIPTION = """\
Print the jobs of a journal, oldest first: when they ran, how they ended, how many items became
what, and why attempts failed. The journal is only read; its node may run or not."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = DESCRIPTION
    _add_choice(parser)
    _add_forms(parser)
    parser.add_argument(
        '-o', '--output', type=Path, metavar='FILE', help='where; else the standard output'
    )
    add_forecast_options(parser)
    add_period_options(parser, 'jobs queued')


def _add_choice(parser: argparse.ArgumentParser) -> None:
    """Declare what chooses jobs and items."""
    add_journal_option(parser)
    parser.add_argument('--job', metavar='JOB', help='this job only')
    parser.add_argument(
        '--item',
        action='append',
        metavar='ITEM',
        help='this item only, and its job, as WO-7/3; may be repeated',
    )
    parser.add_argument('--items', action='store_true', help='also every item, with its results')
    parser.add_argument(
        '--serial', metavar='SERIAL', help='items of this serial only, and their jobs'
    )
    parser.add_argument(
        '--lot',
        type=_lot,
        metavar='NAME=LOT',
        help='items that this went into only, and their jobs, as glue=L-77',
    )


def _add_forms(parser: argparse.ArgumentParser) -> None:
    """Declare the forms of output."""
    form = parser.add_mutually_exclusive_group()
    form.add_argument(
        '--script',
        action='store_true',
        help='with --job: the script that it ran, as a file, in place of the table',
    )
    form.add_argument('--json', action='store_true', help='one JSON object a job and line')
    form.add_argument(
        '--html',
        action='store_true',
        help='with --item, --serial, --lot or --job: the whole record of each item as a document '
        'for a browser and for paper; attempts, results, waits and why, holds and who answered',
    )
    form.add_argument(
        '--record', action='store_true', help='the same as JSON, one object an item and line'
    )
    form.add_argument(
        '--b2mml',
        action='store_true',
        help='the same as job responses for an MES, with the names of B2MML; jobs that have '
        'started',
    )
    form.add_argument(
        '--gantt',
        action='store_true',
        help='draw what each component really did, as SVG: in the time of --job, or of --from and '
        '--to, which then name times of the work',
    )


def _lot(text: str) -> tuple[str, str]:
    name, equals, lot = text.partition('=')
    if not (name and equals and lot):
        raise argparse.ArgumentTypeError(f'a lot is NAME=LOT, found {text!r}')
    return name, lot


def refuse_contradictions(args: argparse.Namespace) -> None:
    """Refuse options that do not go together.

    :raises WrongUse: says which
    """
    if args.script and args.job is None:
        raise WrongUse('--script prints what one job ran; say which: --job JOB')
    if is_record(args) and not (chooses_items(args) or args.job):
        raise WrongUse(
            '--html and --record are about items; say which: --item ITEM, --serial SERIAL, '
            '--lot NAME=LOT or --job JOB'
        )
    if args.gantt and args.job is not None and not (args.since is args.until is None):
        raise WrongUse('--job, or --from and --to, name the time of the chart; leave one out')
    forecast.refuse_contradictions(args)


def is_record(args: argparse.Namespace) -> bool:
    """Tell whether the whole records of items are wanted."""
    return bool(args.html or args.record)


def chooses_items(args: argparse.Namespace) -> bool:
    """Tell whether items are chosen by what they are called or made of."""
    return bool(args.item or args.serial or args.lot)
