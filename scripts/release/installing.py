"""Sdist and wheel as people install them: in new environments, on every Python that is here.

For each Python, `scripts/demo` runs in a copy of the project, as in the README. Then the wheels of
that copy are installed by pip into an environment of nothing else, with every extra, and the same
line runs there, after a script was checked, predicted and drawn. The sdist goes into one without
ROS 2, where the program starts.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

from outcome import Outcome, Place, end_of, run

PYTHONS = ('3.10', '3.11', '3.12', '3.13')
EXTRAS = '[page,opcua,recipes,parquet,postgres,signed]'
DOMAIN = {'ROS_DOMAIN_ID': '38'}
LEFT_OUT = shutil.ignore_patterns('.git', '.venv', 'dist', '__pycache__', '.*_cache')
CELL, SCRIPT = 'config/reference_cell.yaml', 'trees/inspect_and_assemble.yaml'
ORDER = 'config/orders/wo_1001.yaml'


class _Stopped(Exception):
    """A command failed; the text is the end of what it printed."""


def look(place: Place) -> Iterator[Outcome]:
    for version in PYTHONS:
        python = _find(version)
        if python is None:
            yield Outcome(f'Python {version}', 'not on this machine', done=False)
            continue
        with tempfile.TemporaryDirectory() as scratch:
            try:
                found = ', '.join(_install(place.root, python, Path(scratch)))
            except _Stopped as stopped:
                yield Outcome(f'Python {version}', str(stopped), failed=True)
            else:
                yield Outcome(f'Python {version}', found)


def _find(version: str) -> Path | None:
    """Return an interpreter of that version: on PATH, or one that pyenv keeps."""
    on_path = [Path(found)] if (found := shutil.which(f'python{version}')) else []
    kept = sorted((Path.home() / '.pyenv' / 'versions').glob(f'{version}*/bin/python'))
    wanted = f'import sys; sys.exit("%d.%d" % sys.version_info[:2] != "{version}")'
    works = (path for path in (*on_path, *kept) if run(path, '-c', wanted).returncode == 0)
    return next(works, None)


def _install(root: Path, python: Path, scratch: Path) -> Iterator[str]:
    clone, wheels = scratch / 'clone', scratch / 'dist'
    shutil.copytree(root, clone, ignore=LEFT_OUT)
    _do(clone / 'scripts' / 'bootstrap', '--python', python, '--wheels', wheels)
    _completes(_do(clone / 'scripts' / 'demo', cwd=clone))
    yield 'scripts/demo'
    (sdist,) = wheels.glob('bt_orchestrator-*.tar.gz')
    alone = _environment(python, scratch / 'alone')
    _do(alone / 'pip', 'install', '--quiet', sdist)
    for words in (('--version',), ('--help',), ('check', '--help')):
        _do(alone / 'bt-orchestrator', *words)
    yield 'sdist without ROS 2: starts'
    whole = _environment(python, scratch / 'whole')
    (wheel,) = wheels.glob('bt_orchestrator-*.whl')
    _do(whole / 'pip', 'install', '--quiet', '--require-hashes', '-r', wheels / 'requirements.txt')
    interfaces = sorted(wheels.glob('*_interfaces-*.whl'))
    _do(whole / 'pip', 'install', '--quiet', f'{wheel}{EXTRAS}', *interfaces)
    _do(whole / 'pip', 'check')
    share = scratch / 'whole' / 'share' / 'bt_orchestrator'
    program, cell = whole / 'bt-orchestrator', ('--cell', share / CELL)
    for words in (
        ('check', share / SCRIPT, *cell),
        ('simulate', share / ORDER, *cell),
        ('render', share / SCRIPT, *cell, '-o', scratch / 'drawn.svg'),
    ):
        _do(program, *words)
    _completes(_do(program, 'demo', cwd=scratch))
    yield 'wheels with every extra: a line runs'


def _environment(python: Path, folder: Path) -> Path:
    _do(python, '-m', 'venv', folder)
    return folder / 'bin'


def _do(*command: str | Path, cwd: Path | None = None) -> str:
    done = run(*command, cwd=cwd, variables=DOMAIN)
    if done.returncode:
        raise _Stopped(f'{" ".join(map(str, command))}: {end_of(done)}')
    return done.stdout


def _completes(said: str) -> None:
    if 'completed' not in said:
        raise _Stopped(f'expected a completed order, found: {said[-2000:]}')
