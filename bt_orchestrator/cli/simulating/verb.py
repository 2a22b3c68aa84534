"""Two virtual runs side by side: the orders unchanged, and with another cell file or script."""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from bt_orchestrator.base.errors import Refused
from bt_orchestrator.cli import bootstrap
from bt_orchestrator.cli.check import add_cell_options, as_json
from bt_orchestrator.cli.folders import add_recipes_option, recipe_folders, script_folders
from bt_orchestrator.cli.numbers import moment, seconds
from bt_orchestrator.cli.output import WrongUse
from bt_orchestrator.cli.pacing import add_rates_option
from bt_orchestrator.cli.simulating.virtual_run import (
    ROWS,
    Run,
    RunOptions,
    lines_of,
    plain,
    run_jobs,
)
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.script.cell_file import FileKind, file_kind
from bt_orchestrator.script.script_file import read_script
from bt_orchestrator.sim.faults import WrongFaults
from bt_orchestrator.sim.simulation import Outcome
from bt_orchestrator.sim.standing_answers import POSSIBLE
from bt_orchestrator.store.trace import UnusableTrace
from bt_orchestrator.view.report.forecast_text import changes, comparison_lines


class OrderFiles(NamedTuple):
    """Work orders, and where what they need is found."""

    orders: Sequence[Path]
    cell: Path
    trees: Sequence[Path]
    recipes: Sequence[Path]

    def jobs(
        self, types: ActionTypes, instead: bootstrap.Replacement | None = None
    ) -> tuple[Cell, list[bootstrap.Given]]:
        """Read them, and bind them to jobs.

        :raises Refused: with every mistake in all files
        """
        trees, recipes = self.trees, self.recipes
        return bootstrap.load_jobs(self.orders, self.cell, trees, types, instead, recipes)


def what_if_jobs(
    file: Path, orders: OrderFiles, types: ActionTypes, scripts: Sequence[str]
) -> tuple[Cell, list[bootstrap.Given]]:
    """Read the orders again, for the cell or with the script that a file describes.

    :param scripts: names of the scripts that the orders ask for
    :raises Refused: with every mistake in all files
    :raises WrongUse: it is not clear which script it would take the place of
    """
    if file_kind(file) is FileKind.CELL:
        return orders._replace(cell=file).jobs(types)
    name = read_script(file, bootstrap.load_cell(orders.cell, types), types).name
    asked = list(dict.fromkeys(scripts))
    if name not in asked and len(asked) > 1:
        raise WrongUse(
            f'{file} is script {name}, and the orders ask for {", ".join(asked)}; '
            'give it the name of the one whose place it takes'
        )
    instead = bootstrap.Replacement(name if name in asked else asked[0], file)
    return orders.jobs(types, instead)


def change_lines(before: Run, after: Run) -> Iterator[str]:
    """Yield the comparison as text; runs that did not end are shown in full."""
    for name, done in (('before', before), ('after', after)):
        if done.outcome is not Outcome.FINISHED:
            yield f'{name}:'
            yield from (f'  {line}' for line in lines_of(done))
            yield ''
    yield from comparison_lines(before.forecast, after.forecast)
    for name, done in (('before', before), ('after', after)):
        for pace in done.paces:
            of_script = f'{pace.script}: ' if len(done.paces) > 1 else ''
            yield f'{name}, {of_script}{pace.pace or "the line gets stuck"}'


def plain_change(before: Run, after: Run) -> dict[str, Any]:
    """Return the comparison as data that JSON can carry."""
    job_changes = changes(before.forecast, after.forecast)
    return {
        'ok': before.outcome is after.outcome is Outcome.FINISHED,
        'before': plain(before),
        'after': plain(after),
        'changes': [{**change._asdict(), 'percent': change.percent} for change in job_changes],
        'findings': [],
    }


DESCRIPTION = """\
Run work orders through the real tree in virtual time, with the nominal durations of the cell file,
and print what that predicts. The orders are queued at time 0, in the order named."""

EPILOG = """\
faults are written as for sim-cell, see there: --fail component_2a.TASK_A#2=abort

exit status: 0 every job ended, 1 refused, stuck, or held without an answer, 2 wrong use"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = DESCRIPTION
    parser.epilog = EPILOG
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument('orders', nargs='+', type=Path, metavar='ORDER', help='work order (YAML)')
    add_cell_options(parser)
    add_recipes_option(parser)
    _add_record_options(parser)
    add_rates_option(parser)
    parser.add_argument(
        '--fail',
        action='append',
        default=[],
        metavar='COMPONENT.FAULT',
        help='make a component fail; may be repeated',
    )
    _add_hold_options(parser)
    parser.add_argument(
        '--begin',
        type=moment,
        metavar='TIME',
        help='time 0, for orders with a start (default: now), for instance 2026-05-17T14:30',
    )
    parser.add_argument(
        '--what-if',
        type=Path,
        metavar='FILE',
        help='run the orders again with this cell file, or with this script in place of the one '
        'of its name (or the only one); compare both',
    )
    shown = parser.add_mutually_exclusive_group()
    shown.add_argument(
        '--details',
        action='store_true',
        help='print also how busy each section and component is, and what it waits for',
    )
    shown.add_argument('--json', action='store_true', help='the prediction as one JSON object')


def _add_record_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        '--trace',
        type=Path,
        metavar='FILE',
        help='write every event, one JSON object a line, up to wherever the run gets',
    )
    parser.add_argument(
        '--gantt',
        type=Path,
        metavar='FILE.svg',
        help='draw who works, moves, waits and is held when, up to wherever the run gets',
    )
    parser.add_argument(
        '--gantt-rows',
        choices=ROWS,
        default=ROWS[0],
        help='with --gantt: a row a section, or a row a component wherever it works (default: '
        f'{ROWS[0]})',
    )


def _add_hold_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        '--on-hold',
        action='append',
        default=[],
        choices=POSSIBLE,
        help='answer every hold so; repeated: with the first one that the hold offers',
    )
    parser.add_argument(
        '--answer-after',
        type=seconds,
        default=0.0,
        metavar='SECONDS',
        help='virtual seconds from a hold to the answer of --on-hold (default 0)',
    )
    parser.add_argument(
        '--result',
        action='append',
        default=[],
        metavar='TASK.FIELD=VALUE',
        help='with --on-hold mark_done: a result field of a task, for later tasks that refer to '
        'it; may be repeated',
    )


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns the exit status."""
    return simulate(args, bootstrap.installed_types())


def simulate(args: argparse.Namespace, types: ActionTypes) -> int:
    """Simulate what the options name, with the types that are known.

    :raises Refused: a file is refused, and that is not wanted as JSON
    :raises WrongUse: a fault, the trace or the chart cannot be had
    """
    if args.what_if is not None and (args.trace is not None or args.gantt is not None):
        raise WrongUse('--what-if compares two runs; --trace and --gantt are about one')
    if args.begin is None:
        args.begin = time.time()
    try:
        return _compare(args, types) if args.what_if is not None else _run(args, types)
    except Refused as refused:
        if not args.json:
            raise
        print(json.dumps({**as_json(refused.findings), 'outcome': 'refused'}))
        return 1
    except (WrongFaults, UnusableTrace) as error:
        raise WrongUse(str(error)) from error


def _run(args: argparse.Namespace, types: ActionTypes) -> int:
    cell, given = _order_files(args).jobs(types)
    done = run_jobs(cell, given, types, _options(args))
    print(json.dumps(plain(done)) if args.json else _text(done, args))
    return 0 if done.outcome is Outcome.FINISHED else 1


def _text(done: Run, args: argparse.Namespace) -> str:
    return '\n'.join(lines_of(done, with_details=args.details))


def _compare(args: argparse.Namespace, types: ActionTypes) -> int:
    cell, given = _order_files(args).jobs(types)
    scripts = [order.job.script.name for order in given]
    changed = what_if_jobs(args.what_if, _order_files(args), types, scripts)
    before = run_jobs(cell, given, types, _options(args))
    after = run_jobs(*changed, types, _options(args))
    if args.json:
        print(json.dumps(plain_change(before, after)))
    else:
        print('\n'.join(change_lines(before, after)))
    return 0 if before.outcome is after.outcome is Outcome.FINISHED else 1


def _order_files(args: argparse.Namespace) -> OrderFiles:
    trees, recipes = script_folders(args.trees), recipe_folders(args.recipes)
    return OrderFiles(args.orders, args.cell, trees, recipes)


def _options(args: argparse.Namespace) -> RunOptions:
    return RunOptions(
        args.begin,
        args.fail,
        args.on_hold,
        args.answer_after,
        args.trace,
        args.gantt,
        args.result,
        args.gantt_rows,
        args.journal,
    )
