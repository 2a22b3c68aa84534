"""The wheel alone, in an empty environment without ROS 2: everything it reads has been packed."""

from __future__ import annotations

import shutil
import subprocess
import sys
from importlib.metadata import distribution
from pathlib import Path

import pytest
from cell_processes import ROOT

CELL = 'share/bt_orchestrator/config/reference_cell.yaml'
ORDER = 'share/bt_orchestrator/config/orders/wo_1001.yaml'
SCRIPT = 'share/bt_orchestrator/trees/inspect_and_assemble.yaml'


def needed_packages() -> list[Path]:
    """Folders with what the wheel requires, as it is installed here."""
    names, found = ['bt_orchestrator'], set()
    while names:
        name = names.pop()
        for requirement in distribution(name).requires or []:
            needed, _, condition = requirement.partition(';')
            bare = needed.strip().split('[')[0]
            for sign in '<>=!~ ':
                bare = bare.split(sign)[0]
            if 'extra' not in condition and bare not in found:
                found.add(bare)
                names.append(bare)
    return [Path(str(distribution(name).locate_file(''))) for name in found]


@pytest.fixture(scope='module')
def environment(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the wheel, and install it beside nothing but what it requires."""
    folder = tmp_path_factory.mktemp('wheel')
    sources = folder / 'sources'
    shutil.copytree(
        ROOT,
        sources,
        ignore=shutil.ignore_patterns('.*', 'test', 'docs', 'build', '*.egg-info', '__pycache__'),
    )
    build = 'import sys; from setuptools.build_meta import build_wheel; build_wheel(sys.argv[1])'
    run([sys.executable, '-c', build, str(folder)], sources)
    (wheel,) = folder.glob('*.whl')
    empty = folder / 'empty'
    run([sys.executable, '-m', 'venv', '--without-pip', str(empty)], folder)
    python = str(empty / 'bin' / 'python')
    pip = [sys.executable, '-m', 'pip', '--python', python, 'install', '--quiet', '--no-index']
    run([*pip, '--no-deps', str(wheel)], folder)
    return empty
