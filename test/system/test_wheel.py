"""The sdist, in an environment of its own: everything that is read has been packed, twice."""

from __future__ import annotations

import os
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest
from cell_processes import ROOT
from projects import build_sdist

CELL = 'config/reference_cell.yaml'
ORDER = 'config/orders/wo_1001.yaml'
SCRIPT = 'trees/inspect_and_assemble.yaml'
OF_ROS = ('AMENT_', 'LD_', 'PYTHON', 'ROS_', '_ROS_')
SHARED = ('config', 'launch', 'recipes', 'schemas', 'trees')


def run(command: list[str], cwd: Path) -> str:
    bare = {name: text for name, text in os.environ.items() if not name.startswith(OF_ROS)}
    bare['AMENT_PREFIX_PATH'] = sys.prefix  # where ROS 2 has its messages
    done = subprocess.run(
        command, cwd=cwd, env=bare, capture_output=True, text=True, check=False, timeout=240
    )
    assert done.returncode == 0, f'{command}: {done.stdout}{done.stderr}'
    return done.stdout


@pytest.fixture(scope='module')
def environment(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Give an environment with the sdist; what it requires is seen from the one of the tests."""
    folder = tmp_path_factory.mktemp('wheel')
    build_sdist(ROOT, Path(sys.executable), folder, folder)
    (sdist,) = folder.glob('*.tar.gz')
    empty = folder / 'empty'
    run([sys.executable, '-m', 'venv', '--without-pip', str(empty)], folder)
    (site_packages,) = empty.glob('lib/python*/site-packages')
    (site_packages / 'required.pth').write_text(sysconfig.get_path('purelib'))
    pip = [sys.executable, '-m', 'pip', '--python', str(empty / 'bin' / 'python'), 'install']
    alone = ('--no-deps', '--no-index', '--no-build-isolation')
    run([*pip, '--quiet', *alone, str(sdist)], folder)
    return empty


def program(environment: Path, *words: str) -> str:
    return run([str(environment / 'bin' / 'bt-orchestrator'), *words], environment)


def test_every_file_that_is_no_code_is_packed(environment: Path) -> None:
    (installed,) = environment.glob('lib/python*/site-packages/bt_orchestrator')
    share = environment / 'share' / 'bt_orchestrator'
    for source, target in (('bt_orchestrator', installed), *((x, share / x) for x in SHARED)):
        for path in (ROOT / source).rglob('*'):
            if path.is_file() and '__pycache__' not in path.parts:
                assert (target / path.relative_to(ROOT / source)).is_file(), path


def test_it_checks_simulates_and_draws(environment: Path) -> None:
    share = environment / 'share' / 'bt_orchestrator'
    code = 'import bt_orchestrator; print(bt_orchestrator.__file__)'
    where = run([str(environment / 'bin' / 'python'), '-c', code], environment)
    assert where.startswith(str(environment))
    cell = ('--cell', str(share / CELL))
    assert 'fits cell reference_cell' in program(environment, 'check', str(share / SCRIPT), *cell)
    assert 'total time' in program(environment, 'simulate', str(share / ORDER), *cell)
    drawn = environment / 'drawn.svg'
    program(environment, 'render', str(share / SCRIPT), *cell, '-o', str(drawn))
    assert drawn.read_text() == (ROOT / SCRIPT).with_suffix('.svg').read_text()
