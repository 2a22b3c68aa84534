"""The options `--durations` and `--update-durations` of the verb `report`."""

from __future__ import annotations

import argparse
import difflib
import json
from collections.abc import Iterator, Mapping

from bt_orchestrator.cli import bootstrap
from bt_orchestrator.cli.wrong_use import WrongUse
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.script.cell_file import parse_cell
from bt_orchestrator.script.source_text import read_text
from bt_orchestrator.script.writing.duration_edits import NotEditable, with_durations
from bt_orchestrator.view.report.account.period import Period
from bt_orchestrator.view.report.durations.durations import (
    Durations,
    durations,
    lines,
    plain,
    proposals,
    sentence,
)
from bt_orchestrator.view.report.reading import Reading


def add_duration_options(parser: argparse.ArgumentParser) -> None:
    """Declare the output in place of the account."""
    instead = parser.add_mutually_exclusive_group()
    instead.add_argument(
        '--durations',
        action='store_true',
        help='how long each task took against its nominal time (with --cell), and since when it '
        'is slower or faster',
    )
    instead.add_argument(
        '--update-durations',
        action='store_true',
        help='with --cell: propose new nominal times for the cell file, as a diff for `patch -p0`',
    )


def are_wanted(args: argparse.Namespace) -> bool:
    """Tell whether durations are the output in place of the account.

    :raises WrongUse: --update-durations needs --cell, and is no table
    """
    if args.update_durations and args.cell is None:
        raise WrongUse('--update-durations proposes changes of a cell file; name it: --cell CELL')
    if (args.durations or args.update_durations) and args.csv:
        raise WrongUse('durations are printed as text, or with --json; leave --csv out')
    if args.update_durations and args.json:
        raise WrongUse('--update-durations prints a diff; --durations --json has the numbers')
    return bool(args.durations or args.update_durations)


def durations_text(
    reading: Reading, period: Period, args: argparse.Namespace, cell: Cell | None
) -> str:
    """Return what the options ask for.

    :raises NotEditable: the cell file is written so that it cannot be changed piece by piece
    """
    found = durations(reading, period, cell)
    if args.update_durations:
        assert cell is not None
        told = _diff(found, args, cell, bootstrap.installed_types())
    elif args.json:
        told = iter([json.dumps(plain(found), ensure_ascii=False)])
    else:
        told = lines(found)
    return ''.join(f'{line}\n' for line in told)


def _diff(
    found: Durations, args: argparse.Namespace, cell: Cell, types: ActionTypes
) -> Iterator[str]:
    new = proposals(found, cell)
    if not new:
        yield f'# the durations of {args.cell} are what was measured; there is nothing to change'
        return
    for one in found.tasks:
        if one.kind.name in new.get(one.kind.component, {}):
            yield f'# {sentence(one, found)}'
    name, text = str(args.cell), read_text(args.cell)
    after = with_durations(text, name, new)
    _check(parse_cell(after, name, types), new, name)
    yield from difflib.unified_diff(text.splitlines(), after.splitlines(), name, name, lineterm='')


def _check(cell: Cell, new: Mapping[str, Mapping[str, float]], name: str) -> None:
    """Make sure that the proposal says what it is meant to say.

    :raises NotEditable: it does not
    """
    for component, wanted in new.items():
        for task, seconds in wanted.items():
            if cell.components[component].duration_s(task) != seconds:
                raise NotEditable(
                    f'the layout of {name} does not allow the time of {component} {task} to be '
                    f'changed alone; set it to {seconds:g} by hand'
                )
