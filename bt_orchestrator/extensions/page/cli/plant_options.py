"""Options of the verb `page` about the shift that runs, and about the plant."""

from __future__ import annotations

import argparse
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import cast

from bt_orchestrator.base.extending import POSTGRES
from bt_orchestrator.cli import bootstrap
from bt_orchestrator.extensions.page.web.seams import Plant
from bt_orchestrator.ports.plant import PlantCells
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
    parser.add_argument(
        '--plant',
        metavar='ADDRESS',
        help='database of the plant, as postgresql://plant_reader@dbhost/plant: the page '
        'lists its cells (default: it does not)',
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


def cells_of(args: argparse.Namespace) -> PlantCells | None:
    """Return what reads the cells of the plant; None: none is named.

    :raises ExtensionMissing: the extension that reads its database is not installed
    """
    if args.plant is None:
        return None
    POSTGRES.demand()
    module = import_module(f'{POSTGRES.room}.overview')
    return cast('PlantCells', partial(module.cells_of, args.plant))
