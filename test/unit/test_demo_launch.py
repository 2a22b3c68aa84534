"""The launch file, with stand-ins for the packages launch and launch_ros, which PyPI lacks."""

from __future__ import annotations

import argparse
import os
import runpy
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from fakes.action_types import FakeActionTypes
from fakes.shipped import REFERENCE_CELL, ROOT

from bt_orchestrator.cli import bootstrap, main, run, sim_cell
from bt_orchestrator.script.cell_file import read_cell
from bt_orchestrator.view.screen.advice import DEFAULT_NODE


class Described:
    """What the launch file says of one thing."""

    def __init__(self, *words: Any, **settings: Any) -> None:
        self.words = words
        self.settings = settings


class LaunchConfiguration:
    """The value of an argument; the context is a dict here."""

    def __init__(self, name: str) -> None:
        self.name = name

    def perform(self, context: dict[str, str]) -> str:
        return context[self.name]


def _module(name: str, **members: object) -> ModuleType:
    module = ModuleType(name)
    vars(module).update(members)
    return module


class LaunchFile:
    """The launch file, run as `ros2 launch` would."""

    def __init__(self) -> None:
        names = runpy.run_path(str(ROOT / 'launch' / 'demo.launch.py'))
        (entities,) = names['generate_launch_description']().words
        *self.arguments, self.start = entities

    @property
    def defaults(self) -> dict[str, str]:
        return {a.words[0]: a.settings['default_value'] for a in self.arguments}

    def processes(self, **values: str) -> list[dict[str, Any]]:
        nodes = self.start.settings['function']({**self.defaults, **values})
        return [node.settings for node in nodes]


@pytest.fixture
def launched(monkeypatch: pytest.MonkeyPatch) -> LaunchFile:
    def share(package: str) -> str:
        assert package == 'bt_orchestrator'
        return str(ROOT)

    packages = 'ament_index_python.packages'
    stand_ins = (
        _module('launch', LaunchContext=dict, LaunchDescription=Described),
        _module('launch.actions', DeclareLaunchArgument=Described, OpaqueFunction=Described),
        _module('launch.substitutions', LaunchConfiguration=LaunchConfiguration),
        _module('launch_ros'),
        _module('launch_ros.actions', Node=Described),
        _module(packages.partition('.')[0]),
        _module(packages, get_package_share_directory=share),
    )
    for module in stand_ins:
        monkeypatch.setitem(sys.modules, module.__name__, module)
    monkeypatch.setattr(bootstrap, 'installed_types', FakeActionTypes)
    return LaunchFile()


def test_every_argument_is_described_and_has_a_default(launched: LaunchFile) -> None:
    assert list(launched.defaults) == [
        'cell',
        'trees',
        'speed',
        'tick_rate_hz',
        'namespace',
        'page',
        'page_port',
        'shifts',
        'opcua',
        'opcua_port',
    ]
    for argument in launched.arguments:
        assert argument.settings['description'].endswith('.'), argument.words
    for name in ('cell', 'trees'):
        assert Path(launched.defaults[name]).exists()


def test_two_simulators_share_every_component_of_the_cell(launched: LaunchFile) -> None:
    *simulators, _ = launched.processes()
    parser = argparse.ArgumentParser()
    sim_cell.add_arguments(parser)
    parsed = [parser.parse_args(process['arguments']) for process in simulators]
    halves = [args.only[0].split(',') for args in parsed]
    components = read_cell(REFERENCE_CELL, FakeActionTypes()).components
    assert [len(half) for half in halves] == [4, 4]
    assert halves[0] + halves[1] == list(components)
    assert [process['executable'] for process in simulators] == ['sim_cell', 'sim_cell']
    assert len({process['name'] for process in simulators}) == 2


def test_values_reach_the_processes(launched: LaunchFile) -> None:
    *simulators, node = launched.processes(speed='4.0', tick_rate_hz='20', namespace='/cell_b')
    for process in simulators:
        words = process['arguments']
        assert words[words.index('--speed') + 1] == '4.0'
        assert words[words.index('--namespace') + 1] == '/cell_b'
    assert node['executable'] == 'tree_node'
    assert node['namespace'] == '/cell_b'
    file, values = node['parameters']
    assert Path(file).is_file()
    assert values == {
        'cell': str(REFERENCE_CELL),
        'trees': [str(ROOT / 'trees')],
        'tick_rate_hz': 20.0,
        'trust_local_doors': False,
    }


def test_without_a_namespace_none_is_given(launched: LaunchFile) -> None:
    for process in launched.processes()[:2]:
        assert '--namespace' not in process['arguments']


def test_a_page_is_served_if_it_is_wanted(launched: LaunchFile) -> None:
    *_, node, page = launched.processes(page='true', page_port='8181', namespace='/cell_b')
    _, values = node['parameters']
    assert values['trust_local_doors'] is True
    # As launch_ros starts it.
    args = main.parsed([*page['arguments'], '--ros-args', '-r', '__node:=page'])
    assert (args.verb, args.node, args.port) == ('page', '/cell_b/bt_orchestrator', 8181)
    assert args.trust_this_computer
    assert (args.shifts, args.cell) == (None, None)
    (*_, shift) = launched.processes(page='true', shifts='/x/shifts.yaml')
    args = main.parsed(shift['arguments'])
    assert (args.shifts, args.cell) == (Path('/x/shifts.yaml'), REFERENCE_CELL)
    (*_, alone) = launched.processes(page='true')
    assert main.parsed(alone['arguments']).node == DEFAULT_NODE


def test_opc_ua_clients_are_served_on_request(launched: LaunchFile) -> None:
    *_, node, server = launched.processes(opcua='true', opcua_port='4841', namespace='/cell_b')
    _, values = node['parameters']
    assert values['trust_local_doors'] is True
    args = main.parsed([*server['arguments'], '--ros-args', '-r', '__node:=opcua'])
    assert (args.verb, args.node, args.port) == ('opcua', '/cell_b/bt_orchestrator', 4841)
    assert args.insecure


def test_the_programs_exist(launched: LaunchFile) -> None:
    setup = (ROOT / 'setup.py').read_text(encoding='utf-8')
    for process in launched.processes(page='true', opcua='true'):
        assert f"'{process['executable']} = bt_orchestrator.cli" in setup
        # Where `ros2 run` and launch files look.
        program = Path(sys.prefix) / 'lib' / 'bt_orchestrator' / process['executable']
        assert os.access(program, os.X_OK), program
    assert callable(run.tree_node_main)
    assert callable(sim_cell.sim_cell_main)
