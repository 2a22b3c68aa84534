"""Finding the file of a script by its name (formats: commands)."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from bt_orchestrator.base.errors import Finding, Refused
from bt_orchestrator.script.report import START, Place, did_you_mean
from bt_orchestrator.script.source_text import ENDINGS
from bt_orchestrator.script.yaml_nodes import quoted


def find_script(
    name_or_path: str,
    folders: Sequence[Path],
    asked_in: str | None = None,
    place: Place = START,
    unlike_any: str = 'check the name, or give a path',
) -> Path:
    """Return the path of a script.

    A name is looked up as NAME.yaml in each folder in turn. A path, which has a separator or a
    YAML ending, is taken as it is. `asked_in` and `place` name the order that asks for it;
    `unlike_any` is the hint where no name is near.

    :raises Refused: there is no such file
    """
    path = Path(name_or_path) if is_path(name_or_path) else _found(name_or_path, folders)
    if path is not None and _is_file(path):
        return path
    what, hint = _missing_path(path) if path else _missing_name(name_or_path, folders, unlike_any)
    raise Refused([_missing(asked_in or name_or_path, place, what, hint)])


def find_below(name_or_path: str, folders: Sequence[Path], option: str) -> Path:
    """Return the path of a script for a client that is restricted to the folders.

    A name is looked up as above; a path must be below one of the folders. The error tells nothing
    about other files, not even whether they exist.

    :param option: the option that allows every path
    :raises Refused: there is no such file, or it is elsewhere
    """
    if is_path(name_or_path) and not _is_below(Path(name_or_path), folders):
        where = ', '.join(map(str, folders)) or 'none'
        what = f'the path {quoted(name_or_path)} is not in a folder of this node ({where})'
        hint = f'put the script there, or start the node with {option}'
        raise Refused([_missing(name_or_path, START, what, hint)])
    return find_script(name_or_path, folders, unlike_any='check the name')


def _missing(file: str, place: Place, what: str, hint: str) -> Finding:
    return Finding(file, place.line, place.column, what, hint, 'script')


def _is_below(path: Path, folders: Sequence[Path]) -> bool:
    try:
        real = path.resolve()
        return any(real.is_relative_to(folder.resolve()) for folder in folders)
    except (OSError, ValueError, RuntimeError):  # a NUL in it, a circle of links
        return False


def is_path(name_or_path: str) -> bool:
    """Tell whether a script is named by its path."""
    separators = [separator for separator in (os.sep, os.altsep) if separator]
    return any(separator in name_or_path for separator in separators) or name_or_path.endswith(
        ENDINGS
    )


def _found(name: str, folders: Sequence[Path]) -> Path | None:
    candidates = (folder / f'{name}{ENDINGS[0]}' for folder in folders)
    return next((path for path in candidates if _is_file(path)), None)


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def _missing_path(path: Path) -> tuple[str, str]:
    names = [file.name for file in scripts_in(path.parent)]
    near = did_you_mean(path.name, names, 'check the path')
    return f'there is no script file {quoted(str(path))}', near


def _missing_name(name: str, folders: Sequence[Path], unlike_any: str) -> tuple[str, str]:
    known = [file.stem for folder in folders for file in scripts_in(folder)]
    looked = ', '.join(str(folder) for folder in folders) or 'no folder'
    what = f'there is no script {quoted(name)}: looked in {looked}'
    return what, did_you_mean(name, known, unlike_any)


def scripts_in(folder: Path) -> list[Path]:
    """Return the files in a folder that may be scripts; none if it cannot be read."""
    try:
        return sorted(path for path in folder.iterdir() if path.suffix in ENDINGS)
    except (OSError, ValueError):
        return []
