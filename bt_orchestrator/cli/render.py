"""The verb `render`: draw a script for somebody who reviews it."""

from __future__ import annotations

import argparse
from pathlib import Path

from bt_orchestrator.cli import bootstrap
from bt_orchestrator.cli.check import add_cell_options
from bt_orchestrator.cli.folders import script_folders
from bt_orchestrator.cli.wrong_use import WrongUse
from bt_orchestrator.errors import OrchestratorError
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.tree.draw import FORMATS, VIEWS, Drawing, draw

DESCRIPTION = """\
Draw a script: the belt with its sections, every task with its arguments and policies, flags, zones
and initialization. Needs no node. A script that would get stuck is drawn as well; see `check`."""

EPILOG = 'exit status: 0 drawn, 1 the script is refused or cannot be drawn, 2 wrong use'

TEXT = 'dot'
ENDINGS = tuple(f'.{kind}' for kind in (*FORMATS, TEXT))


class CannotWrite(OrchestratorError):
    """The file of a drawing cannot be written."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = DESCRIPTION
    parser.epilog = EPILOG
    parser.add_argument('script', metavar='SCRIPT', help='name or path of a script (YAML)')
    add_cell_options(parser)
    parser.add_argument(
        '-o',
        '--output',
        required=True,
        type=Path,
        metavar='FILE',
        help=f'what to write, its ending says how: {", ".join(ENDINGS)}',
    )
    parser.add_argument(
        '--view',
        choices=VIEWS,
        default=VIEWS[0],
        help='line: the process, for reviewers (default); tree: the behaviours it compiles to',
    )


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns the exit status."""
    kind_of(args.output)
    return render(args, bootstrap.installed_types())


def render(args: argparse.Namespace, types: ActionTypes) -> int:
    """Draw what the options name, with the types that are known.

    :raises WrongUse: the file's ending names no format
    :raises Refused: there are mistakes
    :raises CannotDraw: there is no working `dot`
    :raises CannotWrite: the file cannot be written
    """
    kind = kind_of(args.output)
    folders = script_folders(args.trees)
    cell, script = bootstrap.load_script(args.script, args.cell, folders, types)
    content = _content(draw(script, cell, args.view), kind)
    try:
        args.output.write_bytes(content)
    except OSError as error:
        raise CannotWrite(f'cannot write {args.output}: {error.strerror}') from error
    return 0


def kind_of(path: Path) -> str:
    """Return the format that a file's ending names.

    :raises WrongUse: none
    """
    ending = path.suffix.lower()
    if ending not in ENDINGS:
        found = f'{path.name} has the ending {ending}' if ending else f'{path.name} has no ending'
        raise WrongUse(f'{found}; expected one of {", ".join(ENDINGS)}')
    return ending[1:]


def _content(drawing: Drawing, kind: str) -> bytes:
    return drawing.dot.encode() if kind == TEXT else drawing.image(kind)
