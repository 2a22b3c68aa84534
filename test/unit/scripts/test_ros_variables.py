"""The variables that every Python of the wheels' environment starts with."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.skipif(
    not Path(sys.prefix, 'bootstrap').is_dir(), reason='no environment of scripts/bootstrap'
)


def variable(name: str, **environment: str) -> str:
    """Return a variable as a Python of this environment has it, when its shell has these."""
    code = f'import os; print(os.environ.get({name!r}, ""))'
    bare = {'PATH': os.environ['PATH'], **environment}
    run = subprocess.run(
        [sys.executable, '-c', code], env=bare, capture_output=True, text=True, check=True
    )
    return run.stdout.strip()


def test_an_overlay_stays_after_this_environment(tmp_path: Path) -> None:
    value = variable('AMENT_PREFIX_PATH', AMENT_PREFIX_PATH=f'{tmp_path}:{sys.prefix}')
    assert value.split(':') == [sys.prefix, str(tmp_path)]


def test_another_ros_2_does_not(tmp_path: Path) -> None:
    packages = tmp_path / 'share' / 'ament_index' / 'resource_index' / 'packages'
    packages.mkdir(parents=True)
    (packages / 'rclpy').touch()
    assert variable('AMENT_PREFIX_PATH', AMENT_PREFIX_PATH=str(tmp_path)) == sys.prefix
    lib = f'{tmp_path}/lib'
    value = variable('LD_LIBRARY_PATH', AMENT_PREFIX_PATH=str(tmp_path), LD_LIBRARY_PATH=lib)
    assert lib not in value.split(':')


def test_libraries_of_an_overlay_are_found(tmp_path: Path) -> None:
    lib = f'{tmp_path}/lib'
    value = variable('LD_LIBRARY_PATH', AMENT_PREFIX_PATH=str(tmp_path), LD_LIBRARY_PATH=lib)
    assert {lib, f'{sys.prefix}/lib'} <= set(value.split(':'))


def test_nested_process_keeps_the_same_prefix_path() -> None:
    code = f'import subprocess, sys; subprocess.run([{sys.executable!r}, "-c", sys.argv[1]])'
    inner = 'import os; print(os.environ["AMENT_PREFIX_PATH"])'
    run = subprocess.run(
        [sys.executable, '-c', code, inner], capture_output=True, text=True, check=True
    )
    assert run.stdout.strip().split(':').count(sys.prefix) == 1
