"""What the machine has, and lacks: tried on folders and programs of the test's own."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from bt_orchestrator.base.diagnosis import machine
from bt_orchestrator.base.diagnosis.check import Verdict


@pytest.mark.parametrize(
    ('version', 'verdict'),
    [((3, 9, 18), Verdict.FAIL), ((3, 10, 0), Verdict.OK), ((3, 13, 1), Verdict.OK)],
)
def test_python(version: tuple[int, ...], verdict: Verdict) -> None:
    assert machine.python(version).verdict is verdict


def test_running_python_and_py_trees_pass() -> None:
    assert machine.python().verdict is Verdict.OK
    assert machine.py_trees().verdict is Verdict.OK


@pytest.mark.parametrize(
    ('text', 'numbers'), [('9.1.2', (9, 1, 2)), ('2.6', (2, 6)), ('1.2rc1', (1,)), ('x', ())]
)
def test_numbers_of_a_version(text: str, numbers: tuple[int, ...]) -> None:
    assert machine.number(text) == numbers


def test_a_dot_that_works(tmp_path: Path) -> None:
    _program(tmp_path / 'dot', 'echo "dot - graphviz version 2.43.0" >&2')
    check = machine.dot(str(tmp_path))
    assert (check.verdict, check.found) == (
        Verdict.OK,
        f'dot - graphviz version 2.43.0 at {tmp_path}/dot',
    )


def test_a_dot_that_is_broken_or_missing(tmp_path: Path) -> None:
    assert machine.dot(str(tmp_path)).verdict is Verdict.WARN
    _program(tmp_path / 'dot', 'exit 5')
    check = machine.dot(str(tmp_path))
    assert (check.verdict, check.found) == (Verdict.WARN, f'{tmp_path}/dot ends with 5')


def _program(path: Path, text: str) -> None:
    path.write_text(f'#!/bin/sh\n{text}\n')
    path.chmod(0o755)


def test_prefixes(tmp_path: Path) -> None:
    name, gone = 'AMENT_PREFIX_PATH', tmp_path / 'gone'
    assert machine.prefixes({}).verdict is Verdict.FAIL
    assert machine.prefixes({name: str(tmp_path)}).verdict is Verdict.OK
    check = machine.prefixes({name: f'{tmp_path}{os.pathsep}{gone}'})
    assert check.verdict is Verdict.WARN
    assert check.found == f'no such folder: {gone}'


def test_log_folder_follows_ros_environment(tmp_path: Path) -> None:
    log, home = str(tmp_path / 'log'), str(tmp_path)
    for environment, folder in (
        ({'ROS_LOG_DIR': log, 'HOME': '/nowhere'}, f'{log} (from ROS_LOG_DIR)'),
        ({'ROS_HOME': home, 'HOME': '/nowhere'}, f'{home}/log (from ROS_HOME)'),
        ({'HOME': home}, f'{home}/.ros/log (from HOME)'),
    ):
        check = machine.log_folder(environment)
        assert (check.verdict, check.found) == (Verdict.OK, folder)


def test_a_log_folder_that_cannot_be() -> None:
    assert machine.log_folder({}).verdict is Verdict.FAIL
    check = machine.log_folder({'HOME': '/proc/self'})
    assert check.verdict is Verdict.FAIL
    assert '/proc/self cannot be written' in check.found
    assert 'set HOME' in check.remedy


def test_an_interface_package_that_is_missing_or_broken(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(str(tmp_path))
    broken = tmp_path / 'broken_interfaces'
    broken.mkdir()
    (broken / '__init__.py').write_text('')
    (broken / 'msg.py').write_text('raise ImportError("libx.so: no such file")')
    packages = {'broken_interfaces': (False, 'a'), 'no_interfaces': (True, 'b')}
    monkeypatch.setattr(machine, '_PACKAGES', packages)

    first, second = machine.interface_packages()
    assert (first.verdict, first.found) == (
        Verdict.WARN,
        'cannot be loaded: libx.so: no such file',
    )
    assert second.verdict is Verdict.FAIL
    assert second.found == 'not installed (no module no_interfaces)'


def test_a_clock_that_was_never_set() -> None:
    assert machine.wall_clock(86_400.0).verdict is Verdict.WARN
    assert machine.wall_clock(machine.EARLIEST_S).verdict is Verdict.OK
