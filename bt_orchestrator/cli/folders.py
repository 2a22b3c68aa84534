"""Where shipped files are: scripts, cell files, orders."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from bt_orchestrator.base.errors import Finding, Refused

PACKAGE = 'bt_orchestrator'


def add_trees_option(parser: argparse.ArgumentParser) -> None:
    """Declare where scripts are looked up; `script_folders` takes what is given."""
    parser.add_argument(
        '--trees',
        action='append',
        type=Path,
        default=[],
        metavar='DIR',
        help='folder in which scripts are looked up by name; may be repeated '
        '(default: trees/ here, then the installed ones)',
    )


def add_recipes_option(parser: argparse.ArgumentParser) -> None:
    """Declare where recipes are looked up; `recipe_folders` takes what is given."""
    parser.add_argument(
        '--recipes',
        action='append',
        type=Path,
        default=[],
        metavar='DIR',
        help='folder of recipes, with NAME.overrides.yaml beside NAME.yaml; may be repeated '
        '(default: recipes/ here, then the installed ones)',
    )


def script_folders(asked: Sequence[Path]) -> list[Path]:
    """Return the folders in which scripts are looked up by name, in order.

    Without any asked for: `trees/` in the working directory, then the installed one (formats).
    """
    return _folders(asked, 'trees')


def recipe_folders(asked: Sequence[Path]) -> list[Path]:
    """Return the folders in which recipes are looked up, as `script_folders` does for scripts."""
    return _folders(asked, 'recipes')


def _folders(asked: Sequence[Path], name: str) -> list[Path]:
    if asked:
        return list(asked)
    return [folder for folder in (Path(name), *_shares(name)) if folder.is_dir()]


def shipped(*path: str) -> Path:
    """Return a file that comes with the package.

    :raises Refused: it is not installed
    """
    places = list(_shares(*path))
    file = next((place for place in places if place.exists()), None)
    if file is None:
        what = f'the shipped file is not installed; looked in {", ".join(map(str, places))}'
        raise Refused([Finding('/'.join(path), 1, 1, what, 'install the package again')])
    return file


def _shares(*path: str) -> list[Path]:
    """Return where a shipped file may be: the ROS package, the environment, the source tree."""
    roots = [Path(sys.prefix) / 'share' / PACKAGE, Path(__file__).parents[2]]
    try:
        from ament_index_python.packages import PackageNotFoundError, get_package_share_directory
    except ImportError:
        pass
    else:
        with suppress(OSError, PackageNotFoundError):
            roots.insert(0, Path(get_package_share_directory(PACKAGE)))
    return [root.joinpath(*path) for root in dict.fromkeys(roots)]
