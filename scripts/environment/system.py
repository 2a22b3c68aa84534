"""Packages of the operating system: checked by what they bring, installed with apt-get."""

from __future__ import annotations

import importlib.util
import os
import shutil
import sys
import sysconfig
from pathlib import Path

from commands import run_logged
from report import Failure, step


def install_missing_packages(log: Path) -> None:
    """Install what is missing when that is possible, else name the command that does."""
    missing = _missing_packages()
    if not missing:
        return
    if not can_install():
        raise Failure(
            'system packages are missing; install them and run this again:\n'
            f'    sudo apt-get install -y {" ".join(missing)}'
        )
    install(log, *missing)
    if still := _missing_packages():
        raise Failure(f'apt-get succeeded, but what {" ".join(still)} should bring is not there')


def can_install() -> bool:
    """Tell whether this may install packages of the operating system."""
    return os.geteuid() == 0 and shutil.which('apt-get') is not None


def install(log: Path, *packages: str) -> None:
    """Have apt-get install packages, of its newest lists."""
    with step(f'apt-get install {" ".join(packages)}', lambda: [log]):
        _apt_get(log, 'update')
        _apt_get(log, 'install', '--no-install-recommends', *packages)


def _missing_packages() -> list[str]:
    python = 'python{}.{}'.format(*sys.version_info)
    present = {
        f'{python}-venv': importlib.util.find_spec('ensurepip') is not None,
        f'{python}-dev': Path(sysconfig.get_path('include'), 'Python.h').exists(),
        'g++': bool(shutil.which(os.environ.get('CXX', 'c++'))),
        'graphviz': bool(shutil.which('dot')),
    }
    missing = [package for package, found in present.items() if not found]
    own = [package for package in missing if package.startswith('python')]
    if own and sys.base_prefix != '/usr':
        # apt's packages are for apt's Python.
        raise Failure(f'{sys.executable} lacks ensurepip or Python.h; use another with --python')
    return missing


NO_QUESTIONS = {'DEBIAN_FRONTEND': 'noninteractive'}


def _apt_get(log: Path, *arguments: str) -> None:
    options = ('-y', '-q', '-o', 'DPkg::Lock::Timeout=300')  # another apt-get may be at work
    run_logged(log, 'apt-get', *options, *arguments, variables=NO_QUESTIONS)
