"""The verb `new-cell`: the first three files of somebody's own cell."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Mapping
from pathlib import Path

from bt_orchestrator.base.errors import OrchestratorError, Refused
from bt_orchestrator.cli import bootstrap
from bt_orchestrator.cli.folders import shipped
from bt_orchestrator.cli.numbers import seconds, whole
from bt_orchestrator.cli.output import WrongUse, cannot_write
from bt_orchestrator.cli.verbs import PROGRAM
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.script.cell_file import CELL_FILE
from bt_orchestrator.script.cell_keys import MOST_SECTIONS
from bt_orchestrator.script.orders.by_recipe import recipes
from bt_orchestrator.script.report import START, Report
from bt_orchestrator.script.ros_names import check_token
from bt_orchestrator.script.starter.starter_files import (
    ORDER_FILE,
    RECIPE_FILE,
    SCRIPT,
    SCRIPT_FILE,
    starter_files,
)
from bt_orchestrator.script.starter.starter_plan import FoundServer, Plan, plan_cell

DESCRIPTION = """\
Write a cell file, a script and a work order to begin with, with comments. They work unchanged:
check, render, simulate and sim-cell take them. The schemas beside them let an editor help; they
belong into version control with the rest. Files that exist are left alone."""

EPILOG = """\
--from-graph takes the action servers that run now: their names, types and task constants, and
topics beside them that may be their state. Some facts are guessed, and marked: the section of a
component, the conveyor, and the tasks that place and take out an item.

exit status: 0 written, 1 nothing was written, 2 wrong use"""

SCHEMAS = {
    CELL_FILE: 'cell.schema.json',
    SCRIPT_FILE: 'script.schema.json',
    ORDER_FILE: 'work_order.schema.json',
    RECIPE_FILE: 'recipe.schema.json',
}

SCHEMA_FOLDER = 'schemas'
"""Beside the cell file."""


class NothingWritten(OrchestratorError):
    """The files cannot be written where they belong."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = DESCRIPTION
    parser.epilog = EPILOG
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument('name', metavar='NAME', help='name of the cell, a ROS name token')
    parser.add_argument(
        '--sections', required=True, type=whole, metavar='N', help='positions of the belt'
    )
    parser.add_argument(
        '-o', '--output', type=Path, metavar='FOLDER', help='where to write (default: NAME)'
    )
    parser.add_argument(
        '--recipe',
        action='store_true',
        help='also write what each device can do, and a recipe from which the script is generated',
    )
    parser.add_argument(
        '--from-graph', action='store_true', help='fill in the action servers that run now'
    )
    parser.add_argument(
        '--timeout',
        type=seconds,
        default=5.0,
        metavar='SECONDS',
        help='longest time to look for action servers (default 5)',
    )


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns the exit status."""
    _check(args)
    return new_cell(args, _servers(args), bootstrap.installed_types())


def new_cell(args: argparse.Namespace, servers: Iterable[FoundServer], types: ActionTypes) -> int:
    """Write the files and say what they hold.

    :raises WrongUse: name or number of sections cannot be
    :raises NothingWritten: one of the files exists, or cannot be written
    """
    _check(args)
    folder: Path = args.output or Path(args.name)
    plan = plan_cell(args.sections, servers, types)
    schemas = _schemas()
    places = {file: _from(file, name) for file, name in SCHEMAS.items() if name in schemas}
    texts = (
        recipes().starter(args.name, plan, places, types)
        if args.recipe
        else starter_files(args.name, plan, places)
    )
    _write({folder / name: text for name, text in texts.items()})
    used = {SCHEMAS[file] for file in texts} & schemas.keys()
    kept = {folder / SCHEMA_FOLDER / name: schemas[name] for name in sorted(used)}
    _write({path: text for path, text in kept.items() if not path.exists()})
    for line in _summary(plan, folder, texts, from_graph=args.from_graph):
        print(line)
    return 0


def _from(file: str, schema: str) -> str:
    """Return where a schema is, seen from a file of the cell."""
    return f'{"../" * file.count("/")}{SCHEMA_FOLDER}/{schema}'


def _check(args: argparse.Namespace) -> None:
    report = Report('NAME')
    if not check_token(args.name, 'cell', START, report):
        (finding,) = report.findings
        name = Path(args.name).name
        is_path = (
            args.output is None and name != args.name and check_token(name, '', START, report)
        )
        hint = f'write for instance `{name} -o {args.name}`' if is_path else finding.hint
        raise WrongUse(f'{finding.what}; {hint}')
    if not 1 <= args.sections <= MOST_SECTIONS:
        raise WrongUse(f'--sections must be from 1 to {MOST_SECTIONS}, not {args.sections}')


def _servers(args: argparse.Namespace) -> Iterable[FoundServer]:
    if not args.from_graph:
        return ()
    # Imported here, because files can be written without ROS.
    from bt_orchestrator.ros.diagnosis.graph import find_action_servers

    return find_action_servers(args.timeout)


def _schemas() -> Mapping[str, str]:
    """Return the schemas by the name they get beside the cell; an editor can do without.

    They are copied: a path into this installation would be wrong on every other computer.
    """
    try:
        folder = shipped('schemas')
        return {name: (folder / name).read_text(encoding='utf-8') for name in SCHEMAS.values()}
    except (OSError, Refused):
        return {}


def _write(texts: Mapping[Path, str]) -> None:
    existing = [str(path) for path in texts if path.exists()]
    if existing:
        verb = 'exists' if len(existing) == 1 else 'exist'
        what = f'{", ".join(existing)} {verb} already, and nothing was written'
        raise NothingWritten(f'{what}; choose another folder with -o')
    for path, text in texts.items():
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            with path.open('x', encoding='utf-8') as file:
                file.write(text)
        except OSError as error:
            raise NothingWritten(cannot_write(path, error)) from error


def _summary(plan: Plan, folder: Path, files: Iterable[str], *, from_graph: bool) -> Iterable[str]:
    for name in files:
        yield f'{folder / name} written'
    devices = [plan.conveyor, *plan.components]
    count = sum(1 for device in devices if device.found)
    if from_graph:
        yield f'{count} of {len(devices)} devices found on the ROS graph, the others are examples'
    else:
        yield f'{len(devices)} devices, all of them examples; --from-graph takes those that run'
    yield f'next: cd {folder} && {PROGRAM} check {SCRIPT}'
