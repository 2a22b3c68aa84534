"""The verb `report`: what a shift, a day or a job was worth, and where its time went."""

from __future__ import annotations

import argparse
import difflib
import json
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import IO

from bt_orchestrator.cli import bootstrap
from bt_orchestrator.cli.here import add_journal_option
from bt_orchestrator.cli.journal_file import open_records, say_damage
from bt_orchestrator.cli.output import WrongUse, opened
from bt_orchestrator.cli.reporting.each_cell import each_cell, with_cell
from bt_orchestrator.cli.reporting.following import add_follow_options, follow
from bt_orchestrator.cli.reporting.periods import add_which_options, period_of, periods_of
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.script.cell_file import parse_cell
from bt_orchestrator.script.source_text import read_text
from bt_orchestrator.script.writing.duration_edits import NotEditable, with_durations
from bt_orchestrator.view.report.account.account import Account, account
from bt_orchestrator.view.report.account.named_figures import By
from bt_orchestrator.view.report.account.period import Period
from bt_orchestrator.view.report.account.plain import account_plain, write_csv
from bt_orchestrator.view.report.account.text import account_text
from bt_orchestrator.view.report.beside import Beside, beside
from bt_orchestrator.view.report.beside_words import (
    beside_plain,
    beside_text,
    write_beside_csv,
)
from bt_orchestrator.view.report.durations import (
    Durations,
    durations,
    lines,
    plain,
    proposals,
    sentence,
)
from bt_orchestrator.view.report.reading import Reading

DESCRIPTION = """\
Print the account of a shift, a day, a job, or of a whole journal. It has quantities, the rate
against the pace, OEE with every loss of time down to its holds, stop reasons, failing tasks,
MTBF and MTTR. With --days it shows days or shifts side by side. With --by it shows products, jobs
or components. With --follow it shows the
shift that runs, as it grows. The journal is only read; its node may run or not. docs/account.md
has the definitions."""

EPILOG = """\
exit status: 0 done, 1 refused, nothing to report, or a record is damaged, 2 wrong use"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = DESCRIPTION
    parser.epilog = EPILOG
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    add_journal_option(parser)
    parser.add_argument(
        '--cell',
        type=Path,
        metavar='CELL',
        help='cell file (YAML), whose durations give the pace; without it there is no performance '
        'and no OEE',
    )
    add_which_options(parser)
    parser.add_argument(
        '--by',
        choices=[kind.value for kind in By],
        help='what was made by product (recipe or script) or by job, or lost by component',
    )
    form = parser.add_mutually_exclusive_group()
    form.add_argument(
        '--html', action='store_true', help='as one page for a browser, or for paper'
    )
    form.add_argument('--json', action='store_true', help='as one JSON object')
    form.add_argument('--csv', action='store_true', help='as one table for a spreadsheet')
    add_duration_options(parser)
    add_follow_options(parser)
    parser.add_argument(
        '-o', '--output', type=Path, metavar='FILE', help='where (default: the screen)'
    )


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns 1 if a record is damaged."""
    return each_cell(args, _run, one_only=_OF_ONE_CELL, choosing=('job',))


_OF_ONE_CELL = ('html', 'csv', 'follow', 'output', 'durations', 'update_durations', 'cell')


def _run(args: argparse.Namespace) -> int:
    tells_durations = are_wanted(args)
    if tells_durations and (args.days or args.by):
        raise WrongUse('--durations goes over one period: leave --days and --by out')
    cell = None
    if args.cell is not None:
        cell = bootstrap.load_cell(args.cell, bootstrap.installed_types())
    if args.follow:
        return follow(args, cell)
    with closing(open_records(args.journal)) as records:
        reading = Reading(records, say_damage)
        if tells_durations:
            return _tell_durations(reading, period_of(args, reading), args, cell)
        write = _prepared(reading, args, cell)
    with opened(args.output) as file:
        write(file)
    return 1 if reading.lost else 0


def _prepared(
    reading: Reading, args: argparse.Namespace, cell: Cell | None
) -> Callable[[IO[str]], None]:
    """Read all that a report needs; returns what writes it."""
    if args.days is not None:
        return partial(_write_beside, beside(reading, periods_of(args), cell), args)
    period = period_of(args, reading)
    if args.by is not None:
        return partial(_write_beside, beside(reading, [(period.name, period)], cell), args)
    return partial(_write, account(reading, period, cell), args)


def _tell_durations(
    reading: Reading, period: Period, args: argparse.Namespace, cell: Cell | None
) -> int:
    text = durations_text(reading, period, args, cell)
    with opened(args.output) as file:
        file.write(text)
    return 1 if reading.lost else 0


def _write(made: Account, args: argparse.Namespace, file: IO[str]) -> None:
    if args.html:
        from bt_orchestrator.view.drawing.account.page import account_page

        file.write(account_page(made))
    elif args.csv:
        write_csv(made, file)
    elif args.json:
        text = json.dumps(account_plain(made), ensure_ascii=False)
        file.write(with_cell(text, args) + '\n')
    else:
        file.writelines(f'{line}\n' for line in account_text(made))


def _write_beside(made: Beside, args: argparse.Namespace, file: IO[str]) -> None:
    by = None if args.by is None else By(args.by)
    if args.html:
        from bt_orchestrator.view.drawing.account.beside_page import beside_page

        file.write(beside_page(made, by))
    elif args.csv:
        write_beside_csv(made, by, file)
    elif args.json:
        file.write(json.dumps(beside_plain(made, by), ensure_ascii=False) + '\n')
    else:
        file.writelines(f'{line}\n' for line in beside_text(made, by))


# The options `--durations` and `--update-durations` of the verb `report`.


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
    times = durations(reading, period, cell)
    if args.update_durations:
        assert cell is not None
        output = _diff(times, args, cell, bootstrap.installed_types())
    elif args.json:
        output = iter([json.dumps(plain(times), ensure_ascii=False)])
    else:
        output = lines(times)
    return ''.join(f'{line}\n' for line in output)


def _diff(
    times: Durations, args: argparse.Namespace, cell: Cell, types: ActionTypes
) -> Iterator[str]:
    new = proposals(times, cell)
    if not new:
        yield f'# the durations of {args.cell} are what was measured; there is nothing to change'
        return
    for task in times.tasks:
        if task.kind.name in new.get(task.kind.component, {}):
            yield f'# {sentence(task, times)}'
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
