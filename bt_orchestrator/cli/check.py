"""The verb `check`: all mistakes and warnings of scripts, and of the cell they are for."""

from __future__ import annotations

import argparse
import dataclasses
import json
import sys
from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple

from bt_orchestrator.base.errors import Finding, Refused, counted
from bt_orchestrator.cli import bootstrap
from bt_orchestrator.cli.folders import (
    add_recipes_option,
    add_trees_option,
    recipe_folders,
    script_folders,
)
from bt_orchestrator.cli.here import add_cell_option, cell_here
from bt_orchestrator.cli.output import WrongUse
from bt_orchestrator.cli.pacing import Pacing, add_rates_option
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.recipe import Recipe
from bt_orchestrator.model.script import Script
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.script.checks.warnings import (
    ReadScript,
    of_recipe,
    of_scripts,
    timeless,
    warnings,
)
from bt_orchestrator.script.lookup import find_script
from bt_orchestrator.script.orders.by_recipe import is_recipe
from bt_orchestrator.script.orders.order_file import is_order
from bt_orchestrator.script.shifts.shifts_file import read_reasons, read_shifts
from bt_orchestrator.view.report.pace_text import ScriptPace

DESCRIPTION = """\
Read scripts, recipes and work orders against the cell they are for, and print every mistake in
them as FILE:LINE:COLUMN: WHAT; HINT. Moves nothing and needs no node.

For a script without mistakes it prints the pace: the seconds per item of a full line, by the
durations of the cell file. It names the tasks that limit the pace, and the gain from faster ones.
With `likely` at tasks, or a journal, it prints the expected pace as well.
For a recipe it says whether the cell can do each operation. Only `generate` finds out whether one
script can do all of them in a row. For a work order it also reads the script, or generates that
of its recipe.

Things that are probably not intended are warnings: FILE:LINE:COLUMN: warning: WHAT; HINT on the
standard error. They change nothing without --strict."""

EPILOG = 'exit status: 0 fine, 1 there are mistakes (with --strict: or warnings), 2 wrong use'


PLANT_FILES = {'shifts': 'shifts', 'reasons': 'reasons for stops'}
"""Options for files that belong to no cell, and their content."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = DESCRIPTION
    parser.epilog = EPILOG
    parser.add_argument(
        'scripts',
        nargs='*',
        metavar='SCRIPT',
        help='name or path of a script, or path of a recipe or of a work order (YAML)',
    )
    add_cell_options(parser)
    parser.set_defaults(cell=None)  # files of the plant need none
    for name, of in PLANT_FILES.items():
        what = f'file of the {of} of the plant (YAML), to be checked as well'
        parser.add_argument(f'--{name}', type=Path, metavar='FILE', help=what)
    add_recipes_option(parser)
    add_rates_option(parser)
    parser.add_argument(
        '--json',
        action='store_true',
        help='one JSON object: findings, warnings, ok, paces, recipes, orders',
    )
    parser.add_argument('--strict', action='store_true', help='take warnings for mistakes')


def add_cell_options(parser: argparse.ArgumentParser) -> None:
    """Declare where the cell and the scripts are."""
    add_cell_option(parser)
    add_trees_option(parser)


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns the exit status."""
    return check(args, bootstrap.installed_types())


def check(args: argparse.Namespace, types: ActionTypes) -> int:
    """Check what the options name, with the types that are known.

    :raises Refused: there are mistakes, and they are not wanted as JSON
    """
    if not (args.scripts or any(getattr(args, name) for name in PLANT_FILES)):
        raise WrongUse('check: name a script, a recipe or a work order; or --shifts, --reasons')
    if args.scripts and args.cell is None:
        args.cell = cell_here()
    try:
        plant = _plant_lines(args)
        checked = _read(args, types) if args.scripts else None
    except Refused as refused:
        if not args.json:
            raise
        print(json.dumps({**as_json(refused.findings), 'warnings': []}))
        return 1
    if checked is None:
        print(json.dumps({**as_json(()), 'warnings': []}) if args.json else '\n'.join(plant))
        return 0
    is_fine = not (args.strict and checked.warnings)
    if args.json:
        print(json.dumps({**_plain_checked(checked), 'ok': is_fine}))
        return int(not is_fine)
    warn(checked.warnings)
    if is_fine:
        print('\n'.join([*_lines(checked), *plant]))
    return int(not is_fine)


def _plant_lines(args: argparse.Namespace) -> list[str]:
    """Read the files of the plant that the options name; return a line for each.

    :raises Refused: with the mistakes of all of them
    """
    findings, lines = bootstrap.Findings(), []
    if args.shifts and (shifts := findings.of(partial(read_shifts, args.shifts))):
        lines.append(f'{args.shifts}: {counted(len(shifts.shifts), "shift")}')
    if args.reasons and (reasons := findings.of(partial(read_reasons, args.reasons))):
        lines.append(f'{args.reasons}: {counted(len(reasons), "reason")}')
    findings.refuse()
    return lines


def warn(findings: Iterable[Finding]) -> None:
    """Print warnings on the standard error."""
    for warning in findings:
        what = f'warning: {warning.what}'
        print(dataclasses.replace(warning, what=what), file=sys.stderr)


class _Checked(NamedTuple):
    """Files without mistakes."""

    cell: Cell
    scripts: Sequence[Script]
    recipes: Sequence[Recipe]
    jobs: Sequence[Job]
    warnings: Sequence[Finding]
    pacing: Pacing


def _read(args: argparse.Namespace, types: ActionTypes) -> _Checked:
    """Read all files.

    :raises Refused: with the mistakes of all of them
    """
    folders = script_folders(args.trees)
    recipe_files = [path for name in args.scripts if is_recipe(path := Path(name))]
    order_files = [path for name in args.scripts if is_order(path := Path(name))]
    names = [name for name in args.scripts if Path(name) not in (*recipe_files, *order_files)]
    findings = bootstrap.Findings()
    recipes = findings.of(partial(bootstrap.load_recipes, recipe_files, args.cell, types))
    loaded = findings.of(partial(bootstrap.load_scripts, names, args.cell, folders, types))
    shelf = recipe_folders(args.recipes)
    bind = partial(
        bootstrap.load_jobs, order_files, args.cell, folders, types, recipe_folders=shelf
    )
    bound = findings.of(bind)
    findings.refuse()
    assert recipes is not None
    assert loaded is not None
    assert bound is not None
    cell, scripts = loaded
    paths = [find_script(name, folders) for name in names]
    given = [ReadScript(path, script) for path, script in zip(paths, scripts, strict=True)]
    jobs = [order.job for order in bound[1]]
    problems = warnings(args.cell, cell, given, folders, types)
    ordered = of_scripts(job.script for job in jobs if job.script not in scripts)
    kinds = chain(chain.from_iterable(of_recipe(recipe, cell) for recipe in recipes), ordered)
    problems += timeless(args.cell, cell, kinds)
    return _Checked(cell, scripts, recipes, jobs, problems, Pacing(cell, types, args.journal))


def _lines(checked: _Checked) -> Iterator[str]:
    """Yield that everything is fine."""
    cell = checked.cell
    for script in checked.scripts:
        yield from summary(script, cell, checked.pacing.of(script))
    for recipe in checked.recipes:
        yield _recipe_line(recipe, cell)
    for job in checked.jobs:
        yield from _order_lines(job, cell)
        yield from _pace_lines(checked.pacing.of(job.script))


def _plain_checked(checked: _Checked) -> dict[str, Any]:
    """Return the same as plain data."""
    cell = checked.cell
    of_orders = {job.script.name: job.script for job in checked.jobs}.values()
    paced = (*checked.scripts, *of_orders)
    return {
        'findings': [],
        'warnings': _plain(checked.warnings),
        'paces': [checked.pacing.of(script).plain() for script in paced],
        'recipes': [_plain_recipe(recipe, cell) for recipe in checked.recipes],
        'orders': [_plain_order(job) for job in checked.jobs],
    }


def as_json(findings: Sequence[Finding]) -> dict[str, Any]:
    """Return findings as plain data."""
    return {'findings': _plain(findings), 'ok': not findings}


def _plain(findings: Sequence[Finding]) -> list[dict[str, Any]]:
    names = ('file', 'line', 'column', 'what', 'hint')
    return [{name: getattr(finding, name) for name in names} for finding in findings]


def summary(script: Script, cell: Cell, pace: ScriptPace) -> Iterator[str]:
    """Yield that a script is fine, and how fast the line makes what it says."""
    tasks = sum(1 for tasks in script.sections.values() for _ in tasks.tasks)
    sections = len(script.sections)
    initialization = (
        f' and {len(script.initialization)} of initialization' if script.initialization else ''
    )
    yield (
        f'{script.name}: {counted(tasks, "task")} in {counted(sections, "section")}'
        f'{initialization}, fits cell {cell.name}'
    )
    yield from _pace_lines(pace)


def _pace_lines(pace: ScriptPace) -> Iterator[str]:
    return (f'  {line}' for line in pace.lines())


def _recipe_line(recipe: Recipe, cell: Cell) -> str:
    """Say that a cell can do what a recipe wants."""
    facts = _plain_recipe(recipe, cell)
    choice = f'{facts["with_choice"]} of them in more than one way' if facts['with_choice'] else ''
    return (
        f'{recipe.name}, version {recipe.version}: {counted(facts["operations"], "operation")}, '
        f'cell {cell.name} can do each' + (f', {choice}' if choice else '')
    )


def _plain_recipe(recipe: Recipe, cell: Cell) -> dict[str, Any]:
    able = [
        sum(
            name in component.capabilities
            for component in cell.components.values()
            for name in operation.do
        )
        for operation in recipe.operations
    ]
    return {
        'recipe': recipe.name,
        'version': recipe.version,
        'operations': len(able),
        'with_choice': sum(number > 1 for number in able),
    }


def _order_lines(job: Job, cell: Cell) -> Iterator[str]:
    """Yield that an order is fine, and what its script is made from."""
    made_from = job.script.made_from
    of = f', made from recipe {made_from.recipe} version {made_from.version}' if made_from else ''
    items = counted(job.quantity, 'item')
    yield f'{job.id}: {items} of {job.script.name}{of}, fits cell {cell.name}'


def _plain_order(job: Job) -> dict[str, Any]:
    made_from = job.script.made_from
    return {
        'order': job.id,
        'quantity': job.quantity,
        'script': job.script.name,
        'recipe': made_from.recipe if made_from else None,
        'version': made_from.version if made_from else None,
    }
