"""The verb `render`: draw a script for somebody who reviews it."""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from pathlib import Path

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.base.ordinary_file import read_ordinary
from bt_orchestrator.base.stop_signals import StopSignals
from bt_orchestrator.cli import bootstrap
from bt_orchestrator.cli.check import add_cell_options
from bt_orchestrator.cli.door import STEP_S, Ignoring, open_door
from bt_orchestrator.cli.draw_tree import draw_tree
from bt_orchestrator.cli.folders import script_folders
from bt_orchestrator.cli.node_options import add_node_options
from bt_orchestrator.cli.numbers import seconds
from bt_orchestrator.cli.output import WrongUse, cannot_write
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.jobs.isa95 import OVER
from bt_orchestrator.model.script import Script
from bt_orchestrator.model.status import CellStatus
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.view.drawing.line import draw_line
from bt_orchestrator.view.drawing.picture import DOT, FORMATS, Picture
from bt_orchestrator.view.drawing.status_marks import line_state
from bt_orchestrator.view.screen.machine import read_status

DESCRIPTION = """\
Draw a script: the belt with its sections, every task with its arguments and policies, flags, zones
and initialization. Needs no node. A script that would get stuck is drawn as well; see `check`.

With --live or --status the same drawing shows the state of the line. It marks tasks that run, wait
(and for what), failed or are held, and shows the items and the counts of the flags. The slot of a
section says what it does for a job of another script."""

EPILOG = 'exit status: 0 drawn, 1 the script is refused or cannot be drawn, 2 wrong use'

LINE, TREE = 'line', 'tree'
"""Views: sections, tasks, flags and zones as a process; the py_trees behaviours."""

ENDINGS = tuple(f'.{kind}' for kind in FORMATS)


class CannotWrite(OrchestratorError):
    """The file of a drawing cannot be written."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = DESCRIPTION
    parser.epilog = EPILOG
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument('script', metavar='SCRIPT', help='name or path of a script (YAML)')
    add_cell_options(parser)
    parser.add_argument(
        '-o',
        '--output',
        required=True,
        type=Path,
        metavar='FILE',
        help=f'the file to write, its ending is the format: {", ".join(ENDINGS)} (the tree)',
    )
    parser.add_argument(
        '--view',
        choices=(LINE, TREE),
        default=LINE,
        help='line: the process, for reviewers (default); tree: the behaviours it compiles to',
    )
    source = parser.add_mutually_exclusive_group()
    source.add_argument('--live', action='store_true', help='show the state of a running node')
    source.add_argument(
        '--status',
        type=Path,
        metavar='FILE',
        help='show the state that `status --json` printed into a file',
    )
    parser.add_argument(
        '--every',
        type=seconds,
        metavar='SECONDS',
        help='with --live: draw again when something changed, at most so often, until the jobs of '
        'the script have ended, or Ctrl-C; the file is replaced as a whole',
    )
    add_node_options(parser)


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns the exit status."""
    _refuse_nonsense(args)
    return render(args, bootstrap.installed_types())


def render(args: argparse.Namespace, types: ActionTypes) -> int:
    """Draw what the options name, with the types that are known.

    :raises WrongUse: the file's ending names no format
    :raises Refused: there are mistakes
    :raises CannotDraw: CairoSVG (PNG and PDF of a line) or `dot` (a tree) is missing
    :raises CannotWrite: the file cannot be written
    :raises CannotRead: the file of a status cannot be read
    :raises NotThisLine: the status is of another cell
    :raises NodeUnreachable: the node does not answer
    """
    kind = kind_of(args.output)
    folders = script_folders(args.trees)
    cell, script = bootstrap.load_script(args.script, args.cell, folders, types)

    def picture(status: CellStatus | None) -> None:
        _write(args.output, _picture(args.view, script, cell, status).content(kind))

    if args.live and args.every is not None:
        follow(args.node, args.timeout, script.name, args.every, picture)
    elif args.live:
        picture(node_status(args.node, args.timeout))
    else:
        picture(None if args.status is None else saved_status(args.status))
    return 0


def _refuse_nonsense(args: argparse.Namespace) -> None:
    """Refuse options that have no meaning together.

    :raises WrongUse: the options contradict each other, or the file's ending names no format
    """
    if args.view == LINE and kind_of(args.output) == DOT:
        raise WrongUse(
            f'{args.output.name}: a line is drawn as .svg, .png or .pdf; .dot is for the '
            f'behaviour tree (--view {TREE})'
        )
    if args.view != LINE and (args.live or args.status is not None):
        raise WrongUse(f'--view {args.view} shows no state; leave it out')
    if args.every is not None and not args.live:
        raise WrongUse('--every is for --live')


def _write(path: Path, content: bytes) -> None:
    """Write a file at once: who looks at it meanwhile sees the old one or the new one."""
    beside = path.with_name(f'.{path.name}.part')
    try:
        beside.write_bytes(content)
        beside.replace(path)
    except OSError as error:
        beside.unlink(missing_ok=True)
        raise CannotWrite(cannot_write(path, error)) from error


def kind_of(path: Path) -> str:
    """Return the format that a file's ending names.

    :raises WrongUse: none
    """
    ending = path.suffix.lower()
    if ending not in ENDINGS:
        problem = (
            f'{path.name} has the ending {ending}' if ending else f'{path.name} has no ending'
        )
        raise WrongUse(f'{problem}; expected one of {", ".join(ENDINGS)}')
    return ending[1:]


def _picture(view: str, script: Script, cell: Cell, status: CellStatus | None) -> Picture:
    if view == TREE:
        return draw_tree(script, cell)
    return draw_line(script, cell, None if status is None else line_state(status, script, cell))


# Drawing what a node says, once or again and again.

LARGEST_FILE = 100_000_000
"""Bytes; a status of 100 jobs and sections has some 200,000."""


class CannotRead(OrchestratorError):
    """The file of a status cannot be read."""


def saved_status(path: Path) -> CellStatus:
    """Read what `status --json` printed.

    :raises CannotRead: there is no such file, or it holds something else
    """
    try:
        plain = json.loads(read_ordinary(path, LARGEST_FILE))
    except OSError as error:
        raise CannotRead(f'cannot read {path}: {error.strerror}; check the path') from error
    except (RecursionError, ValueError) as error:
        raise CannotRead(
            f'{path} is not JSON: {error}; expected what status --json prints'
        ) from error
    try:
        return read_status(plain)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise CannotRead(
            f'{path} holds no status of a cell ({error!r}); expected what status --json of this '
            'version prints'
        ) from error


def node_status(node: str, timeout_s: float) -> CellStatus:
    """Ask a node.

    :raises NodeUnreachable: it does not answer
    """
    with open_door(node, timeout_s) as door:
        return door.status()


def follow(
    node: str, timeout_s: float, script: str, every_s: float, draw: Callable[[CellStatus], None]
) -> None:
    """Draw every change, until a job of the script has ended and no other one is left, or Ctrl-C.

    :param every_s: shortest time between two drawings
    :raises NodeUnreachable: it does not answer
    """
    newest, course = _Newest(), Course(script)
    with StopSignals() as stop, open_door(node, timeout_s) as door:
        door.follow(newest)
        drawn_at = -every_s
        while not stop.requested and not course.is_over:
            if newest.status is not None and time.monotonic() >= drawn_at + every_s:
                drawn_at = time.monotonic()
                status, newest.status = newest.status, None
                draw(status)
                course.look(status)
            door.turn(STEP_S)


class _Newest(Ignoring):
    """Keeps the last status that came."""

    status: CellStatus | None = None

    def on_status(self, status: CellStatus) -> None:
        self.status = status


class Course:
    """Whether to wait for the jobs of a script. States: expected, live, over."""

    def __init__(self, script: str) -> None:
        self._script = script
        self._was_live = False
        self.is_over = False

    def look(self, status: CellStatus) -> None:
        """Take note of a status."""
        states = [job.state for job in status.jobs if job.script == self._script]
        is_live = any(state not in OVER for state in states)
        self.is_over = self._was_live and not is_live
        self._was_live |= is_live
