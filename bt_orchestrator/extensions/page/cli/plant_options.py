"""Options of the verb `page` about the account of the shift that runs."""

from __future__ import annotations

import argparse
from pathlib import Path

from bt_orchestrator.cli import bootstrap
from bt_orchestrator.extensions.page.web.seams import Plant
from bt_orchestrator.script.shifts.shifts_file import read_shifts


def add_plant_options(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        '--shifts',
        type=Path,
        metavar='FILE',
        help='file of shifts (YAML): the page shows OEE and losses of the shift that runs '
        '(default: it does not)',
    )
    parser.add_argument(
        '--cell',
        type=Path,
        metavar='CELL',
        help='cell file (YAML), whose durations give the pace of a shift; without it there is no '
        'performance and no OEE; without --shifts it is of no use',
    )


def plant_of(args: argparse.Namespace) -> Plant | None:
    """Return what the options say together; None: no account is wanted.

    :raises Refused: a file has mistakes
    """
    if args.shifts is None:
        return None
    cell = None
    if args.cell is not None:
        cell = bootstrap.load_cell(args.cell, bootstrap.installed_types())
    return Plant(read_shifts(args.shifts), cell)
