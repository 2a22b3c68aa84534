"""Builds wheels of what lies here as source: interface packages, and bt_orchestrator.

Each is built from a copy, against what is installed in the environment. A wheel of interfaces
takes ten seconds, and depends on nothing but its definitions, builder, Python and compiler; so it
is kept in the user's cache, for the next clone and for an environment that is made anew.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from commands import clean_environment, run_logged
from report import Failure, say
from sources import copy_tree, digest, find_sources

PACKAGE = 'bt_orchestrator'
# All that setup.py packs, and itself.
PACKED = (
    *(PACKAGE, 'config', 'launch', 'recipes', 'resource', 'schemas', 'trees'),
    *('LICENSE', 'NOTICE', 'package.xml', 'pyproject.toml', 'setup.cfg', 'setup.py'),
)
KEPT_WHEELS = 12


@dataclass(frozen=True)
class Project:
    """Something to build: `build(logs, wheels)` leaves its wheel in the folder `wheels`."""

    name: str
    stamp: str
    """Changes with everything that the wheel depends on."""
    build: Callable[[Path, Path], None]


def read_list(path: Path) -> list[Path]:
    """Return the user's own folders of interfaces, those that are still there."""
    if not path.exists():
        return []
    folders = [Path(line) for line in path.read_text().splitlines() if line]
    for gone in (folder for folder in folders if not folder.is_dir()):
        say(
            f'{gone}, a line of {path}, is no folder any more; its interfaces are left as they are'
        )
    return [folder for folder in folders if folder.is_dir()]


def remember(folder: str, path: Path) -> None:
    """Add a folder of interfaces to the list in `path`."""
    added = Path(folder).resolve()
    name_of(added)  # or it is none
    if added not in read_list(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open('a') as file:
            file.write(f'{added}\n')


def name_of(folder: Path) -> str:
    """Return the name that package.xml gives to an interface package."""
    try:
        name = ElementTree.parse(folder / 'package.xml').getroot().findtext('name')
    except (OSError, ElementTree.ParseError) as error:
        raise Failure(
            f'{folder}: expected an interface package with package.xml; {error}'
        ) from None
    if not name:
        raise Failure(f'{folder}/package.xml: expected <name>, found none')
    return name


def interface_project(folder: Path, builder: Path, python: Path, foundation: str) -> Project:
    """Describe an interface package; `builder` is the folder of ``rosidl_pip``."""
    name = name_of(folder)
    sources = find_sources(folder)
    tools = find_sources(builder)
    stamp = digest(sources, folder, digest(tools, builder, foundation), _compiler())

    def build(scratch: Path, wheels: Path) -> None:
        kept = _cache() / stamp
        if _take(kept, wheels):
            return
        copy_tree(sources, folder, scratch / name)
        run_logged(
            scratch.parent / f'{name}.log',
            *(str(python), '-m', 'rosidl_pip', str(scratch / name), str(wheels)),
            variables={'PYTHONPATH': str(builder.parent), 'PYTHONDONTWRITEBYTECODE': '1'},
        )
        _keep(wheels, kept)

    return Project(name, stamp, build)


def package_project(root: Path, python: Path, foundation: str) -> Project:
    """Describe bt_orchestrator itself."""
    sources = find_sources(*(root / name for name in PACKED))

    def build(scratch: Path, wheels: Path) -> None:
        copy_tree(sources, root, scratch / PACKAGE)
        code = (
            'import sys; from setuptools.build_meta import build_wheel; build_wheel(sys.argv[1])'
        )
        command = (str(python), '-c', code, str(wheels))
        run_logged(scratch.parent / f'{PACKAGE}.log', *command, cwd=scratch / PACKAGE)

    return Project(PACKAGE, digest(sources, root, foundation), build)


def build_sdist(root: Path, python: Path, target: Path, state: Path) -> None:
    """Pack the sources of bt_orchestrator itself as pip takes them, into `target`."""
    copy = state / 'sdist'
    copy_tree(find_sources(*(root / name for name in PACKED)), root, copy)
    code = 'import sys; from setuptools.build_meta import build_sdist; build_sdist(sys.argv[1])'
    run_logged(state / 'sdist.log', str(python), '-c', code, str(target.absolute()), cwd=copy)
    shutil.rmtree(copy)


def _compiler() -> str:
    command = [os.environ.get('CXX', 'c++'), '--version']
    return subprocess.run(
        command, check=False, capture_output=True, text=True, env=clean_environment()
    ).stdout


def _cache() -> Path:
    home = os.environ.get('XDG_CACHE_HOME') or Path('~/.cache').expanduser()
    return Path(home, PACKAGE, 'interfaces')


def _take(kept: Path, wheels: Path) -> bool:
    with suppress(OSError):
        for wheel in kept.glob('*.whl'):
            shutil.copy(wheel, wheels)
            os.utime(kept)  # used just now
            return True
    return False


def _keep(wheels: Path, kept: Path) -> None:
    """Whole or not at all, and without complaint where there is no home or no room."""
    with suppress(OSError):
        kept.parent.mkdir(parents=True, exist_ok=True)
        unfinished = kept.with_name(f'{kept.name}.{os.getpid()}')
        shutil.copytree(wheels, unfinished)
        unfinished.rename(kept)
        old = sorted(kept.parent.iterdir(), key=lambda path: path.stat().st_mtime)
        for folder in old[:-KEPT_WHEELS]:
            shutil.rmtree(folder, ignore_errors=True)
