"""Programs, Python packages and folders that a cell needs."""

from __future__ import annotations

import importlib
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from importlib import metadata
from pathlib import Path

from bt_orchestrator.base.diagnosis.check import Check, fail, ok, warn

OLDEST_PYTHON = (3, 10)
PY_TREES = ((2, 2), (2, 7))
"""From, and before."""

EARLIEST_S = 1_577_836_800
"""Start of 2020: a clock that shows less was never set."""

_PACKAGES: Mapping[str, tuple[bool, str]] = {
    'bt_orchestrator_interfaces': (True, 'the services and topics of the tree node'),
    'py_trees_ros_interfaces': (False, 'what tree watchers attach to'),
}
"""Interface packages: whether nothing goes without, and what they are for."""


def python(version: tuple[int, ...] = sys.version_info[:3]) -> Check:
    """Look at the version of Python."""
    finding = f'{".".join(map(str, version))} at {sys.executable}'
    if version >= OLDEST_PYTHON:
        return ok('python', finding)
    oldest = '.'.join(map(str, OLDEST_PYTHON))
    return fail('python', finding, f'use Python {oldest} or newer')


def py_trees() -> Check:
    """Look at the version of py_trees."""
    try:
        version = metadata.version('py_trees')
    except metadata.PackageNotFoundError:
        remedy = 'install it: apt install ros-$ROS_DISTRO-py-trees'
        return fail('py_trees', 'not installed', remedy)
    oldest, next_one = PY_TREES
    if oldest <= number(version) < next_one:
        return ok('py_trees', version)
    wanted = f'{oldest[0]}.{oldest[1]} or newer, before {next_one[0]}.{next_one[1]}'
    return warn('py_trees', version, f'not tried with this version; use {wanted}')


def number(version: str) -> tuple[int, ...]:
    """Return the leading numbers of a version, for comparisons."""
    numbers = []
    for part in version.split('.'):
        if not part.isdigit():
            break
        numbers.append(int(part))
    return tuple(numbers)


def dot(path: str | None = None) -> Check:
    """Look for Graphviz, which draws the behaviour tree.

    :param path: folders to look in instead of PATH
    """
    program = shutil.which('dot', path=path)
    if program is None:
        remedy = '`render --view tree` can write .dot files only; apt install graphviz'
        return warn('dot', 'not found on PATH', remedy)
    process = subprocess.run([program, '-V'], capture_output=True, text=True, check=False)
    if process.returncode:
        return warn('dot', f'{program} ends with {process.returncode}', 'apt install graphviz')
    return ok('dot', f'{process.stderr.strip() or process.stdout.strip()} at {program}')


def interface_packages() -> Iterator[Check]:
    """Try to load the interface packages."""
    for name, (needed, purpose) in _PACKAGES.items():
        bad = fail if needed else warn
        try:
            importlib.import_module(f'{name}.msg')
        except ModuleNotFoundError as error:
            remedy = f'it has {purpose}; build it and source its workspace'
            yield bad(name, f'not installed (no module {error.name})', remedy)
        except ImportError as error:
            yield bad(name, f'cannot be loaded: {error}', 'build it again with this Python')
        else:
            yield ok(name, 'installed')


def prefixes(environment: Mapping[str, str]) -> Check:
    """Look at AMENT_PREFIX_PATH, by which ROS 2 finds what is installed."""
    name = 'AMENT_PREFIX_PATH'
    folders = [folder for folder in environment.get(name, '').split(os.pathsep) if folder]
    if not folders:
        return fail(name, 'not set', 'source the setup.bash of ROS 2, and of your workspace')
    missing = [folder for folder in folders if not Path(folder).is_dir()]
    if missing:
        remedy = 'a workspace was moved or removed: open a new shell and source it again'
        return warn(name, f'no such folder: {", ".join(missing)}', remedy)
    return ok(name, ', '.join(folders))


def log_folder(environment: Mapping[str, str]) -> Check:
    """Look whether ROS 2 can write its logs, without which no node starts."""
    name = next(
        (
            variable
            for variable in ('ROS_LOG_DIR', 'ROS_HOME', 'HOME')
            if environment.get(variable)
        ),
        '',
    )
    if not name:
        remedy = 'set HOME or ROS_LOG_DIR to a folder that can be written'
        return fail('log folder', 'neither HOME nor ROS_LOG_DIR is set', remedy)
    below = {'ROS_LOG_DIR': '', 'ROS_HOME': 'log', 'HOME': '.ros/log'}[name]
    folder = Path(environment[name]).expanduser() / below
    problem = _why_not_writable(folder)
    if problem is None:
        return ok('log folder', f'{folder} (from {name})')
    return fail('log folder', problem, f'set {name} to a folder that can be written')


def _why_not_writable(folder: Path) -> str | None:
    """Say why nothing can be written below a folder that may have to be made first."""
    there = next(path for path in (folder, *folder.parents) if path.exists())
    try:
        with tempfile.TemporaryFile(dir=there):
            return None
    except OSError as error:
        return f'{folder}: {there} cannot be written ({error.strerror})'


def wall_clock(now: float) -> Check:
    """Look whether the computer's clock was ever set.

    :param now: seconds since the epoch
    """
    if now >= EARLIEST_S:
        return ok('wall clock', 'set')
    remedy = 'times in the journal would be wrong; set the clock (timedatectl)'
    return warn('wall clock', 'shows a time before 2020', remedy)
