"""Cell file and journal of the current folder, for a verb that is not told which to take."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

from bt_orchestrator.cli.output import WrongUse
from bt_orchestrator.model.keeping.journal_place import journal_place
from bt_orchestrator.script.cell_file import CELL_FILE


def add_cell_option(parser: argparse.ArgumentParser) -> None:
    """Declare the cell file."""
    parser.add_argument(
        '--cell',
        type=_path_or(_cell_here),
        default='',
        metavar='CELL',
        help=f'cell file (YAML; default: {CELL_FILE} in this folder)',
    )


def add_journal_option(parser: argparse.ArgumentParser) -> None:
    """Declare the journal."""
    parser.add_argument(
        '--journal',
        type=lambda text: journal_place(text) if text else _journal_here(),
        default='',
        metavar='FILE',
        help='the journal, a file or an address of a database (default: the one in this folder)',
    )


def cell_here() -> Path:
    """Return the cell file of this folder, where no option named one.

    :raises WrongUse: there is none
    """
    try:
        return _cell_here()
    except argparse.ArgumentTypeError as error:
        raise WrongUse(f'argument --cell: {error}') from None


def _path_or(find: Callable[[], Path]) -> Callable[[str], Path]:
    """Return what reads the value of an option; argparse asks it for the default as well."""

    def path(text: str) -> Path:
        return Path(text) if text else find()

    return path


def _cell_here() -> Path:
    path = Path(CELL_FILE)
    if not path.exists():
        raise argparse.ArgumentTypeError(
            f'expected a cell file; there is no {CELL_FILE} in {Path.cwd()}; name it: --cell CELL'
        )
    return _taken('cell file', path)


def _journal_here() -> Path:
    # Imported here, so that other verbs load no SQLite.
    from bt_orchestrator.store.shared.mark import MARK

    marks = sorted(path.name for path in Path().glob(f'*{MARK}'))
    journals = [Path(name) for mark in marks if Path(name := mark.removesuffix(MARK)).exists()]
    if len(journals) != 1:
        names = ', '.join(map(str, journals)) or 'none'
        raise argparse.ArgumentTypeError(
            f'expected one journal in {Path.cwd()}; found {names}; name it: --journal FILE'
        )
    return _taken('journal', journals[0])


def _taken(what: str, path: Path) -> Path:
    print(f'{what}: {path}', file=sys.stderr)
    return path
