"""A verb that reads a journal, on each cell of a plant's database."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.cli.journal_file import journals_of
from bt_orchestrator.cli.output import WrongUse
from bt_orchestrator.model.codec import json_of


def each_cell(
    args: argparse.Namespace,
    run: Callable[[argparse.Namespace], int],
    *,
    one_only: Sequence[str] = (),
    choosing: Sequence[str] = (),
) -> int:
    """Carry out a verb on the journal that is named, or on each cell of the plant that is.

    :param run: takes the arguments of one cell, and returns the exit status
    :param one_only: options whose output is of one cell
    :param choosing: options by which some cells have nothing to show: then the best status counts
    :raises WrongUse: a plant is named with an option that is of one cell
    """
    if isinstance(args.journal, Path) or (journals := journals_of(args.journal)) is None:
        return run(args)
    for option in one_only:
        if getattr(args, option):
            name = option.replace('_', '-')
            raise WrongUse(f'--{name} is of one cell: name it behind the database, /CELL')
    statuses = []
    for cell, place in journals:
        of_cell = argparse.Namespace(**{**vars(args), 'journal': place, 'of_cell': cell})
        if not says_json(args):
            print(f'== {cell}', flush=True)
        try:
            statuses.append(run(of_cell))
        except WrongUse:
            raise
        except OrchestratorError as error:  # the other cells are shown all the same
            print(f'{cell}: {error}', file=sys.stderr)
            statuses.append(1)
    chooses = any(getattr(args, option) for option in choosing)
    return min(statuses, default=0) if chooses else max(statuses, default=0)


def says_json(args: argparse.Namespace) -> bool:
    """Tell whether the output is an object a line: then each object names its cell."""
    return bool(getattr(args, 'json', False) or getattr(args, 'format', '') is None)


def with_cell(text: str, args: argparse.Namespace) -> str:
    """Return a JSON object with the cell that it is of, if several are shown."""
    cell = getattr(args, 'of_cell', '')
    return f'{{"plant_cell": {json_of(cell)}, {text[1:]}' if cell else text
