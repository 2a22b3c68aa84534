"""Starter cells: whatever was found on the graph, what is written can be run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import pytest
from fakes.action_types import ACTIONS, FakeActionTypes, action
from fakes.schemas import refusals
from hypothesis import given
from hypothesis import strategies as st

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.script import Script
from bt_orchestrator.script.cell_file import CELL_FILE, parse_cell
from bt_orchestrator.script.orders.order_file import bind_order, parse_order
from bt_orchestrator.script.script_file import parse_script
from bt_orchestrator.script.starter.starter_files import (
    ORDER_FILE,
    SCRIPT_FILE,
    starter_files,
)
from bt_orchestrator.script.starter.starter_plan import FoundServer, plan_cell

LAZY = action('lazy_interfaces/action/Lazy', ('PREPARE',), {}, {})
MUTE = replace(action('mute_interfaces/action/Mute', ('X',), {}, {}), constants={})
"""Its goals have a task field that no constant is for."""


class Types(FakeActionTypes):
    def __init__(self) -> None:
        super().__init__()
        self._actions |= {LAZY.name: LAZY, MUTE.name: MUTE}


TYPES = Types()
EXAMPLES = 'bt_orchestrator_interfaces/action/'


def server(action: str, type_name: str, *state_topics: str) -> FoundServer:
    return FoundServer(action, type_name, '/controllers', state_topics)


def texts(sections: int, servers: Sequence[FoundServer] = ()) -> dict[str, str]:
    return starter_files('mine', plan_cell(sections, servers, TYPES), {})


def read(files: dict[str, str]) -> tuple[Cell, Script]:
    """Read all three files, as `submit` would."""
    cell = parse_cell(files[CELL_FILE], CELL_FILE, TYPES)
    script = parse_script(files[SCRIPT_FILE], SCRIPT_FILE, cell, TYPES)
    order = parse_order(files[ORDER_FILE], ORDER_FILE)
    assert bind_order(order.order, script, 'WO-1').quantity == 3
    return cell, script


@pytest.mark.parametrize('sections', [1, 2, 3, 9])
def test_examples_stand_along_the_whole_belt(sections: int) -> None:
    cell, script = read(texts(sections))
    assert cell.conveyor.sections == sections
    assert [*script.sections] == [*range(1, sections + 1)]
    assert (script.source, script.sink) == (1, sections)


def test_editors_accept_the_files() -> None:
    files = texts(3, [server('/x/task', EXAMPLES + 'Component', '/x/state')])
    assert refusals('cell.schema.json', files[CELL_FILE]) == []
    assert refusals('script.schema.json', files[SCRIPT_FILE]) == []
    assert refusals('work_order.schema.json', files[ORDER_FILE]) == []


def test_file_names_its_schema_if_available() -> None:
    files = starter_files('mine', plan_cell(2, (), TYPES), {CELL_FILE: '/share/a.json'})
    assert files[CELL_FILE].startswith('# yaml-language-server: $schema=/share/a.json\n')
    assert 'yaml-language-server' not in files[ORDER_FILE]


def test_discovered_servers_get_sections_that_their_tasks_imply() -> None:
    servers = [
        server('/belt/drive', EXAMPLES + 'Conveyor'),
        server('/cell/left/task', EXAMPLES + 'PackingArm'),
        server('/cell/right/task', EXAMPLES + 'UnpackingArm', '/cell/right/state'),
        server('/camera/task', EXAMPLES + 'Component'),
        server('/press/task', EXAMPLES + 'Component'),
    ]
    files = texts(4, servers)
    cell, script = read(files)
    assert cell.conveyor.component.action == '/belt/drive'
    assert cell.conveyor.task == 'MOVE_ONE_INDEX'
    sections = {name: part.sections for name, part in cell.components.items() if part.sections}
    assert sections == {'right': (1,), 'camera': (2,), 'press': (3,), 'left': (4,)}
    place, pack = (task for task in script.tasks.values() if task.qty_change)
    assert (place.name, place.qty_change) == ('PLACE_AT_CONVEYOR', 1)
    assert (pack.name, pack.qty_change) == ('PICK_AND_PACK', -1)
    assert '# state: {topic: /cell/right/state, ' in files[CELL_FILE]
    assert files[CELL_FILE].count('served by /controllers') == 5
    assert 'an example' not in files[CELL_FILE]


def test_sections_without_a_found_device_get_an_example() -> None:
    cell, _ = read(texts(4, [server('/press/task', EXAMPLES + 'Component')]))
    assert [*cell.components][1:] == ['loader', 'press', 'station_3', 'packer']


def test_unusable_server_is_named_in_a_comment() -> None:
    files = texts(2, [server('/strange/thing', 'strange_interfaces/action/Thing')])
    read(files)
    assert '#   /strange/thing: strange_interfaces/action/Thing\n' in files[CELL_FILE]


def test_conveyor_is_recognized_by_name_without_task() -> None:
    cell, script = read(texts(2, [server('/line/belt', 'plain_interfaces/action/Index')]))
    assert (cell.conveyor.component.action, cell.conveyor.task) == ('/line/belt', 'Index')
    assert 'conveyor' not in {task.component for task in script.tasks.values()}


def test_device_that_only_prepares_does_so_as_work() -> None:
    _, script = read(texts(3, [server('/lazy/task', LAZY.name)]))
    assert script.tasks['lazy_prepare'] in script.sections[2].tasks


def test_two_devices_of_one_name_are_told_apart() -> None:
    servers = [server(f'/{side}/arm/task', EXAMPLES + 'Component') for side in ('left', 'right')]
    cell, _ = read(texts(3, servers))
    assert {'arm', 'arm_2'} < {*cell.components}


NAMES = st.sampled_from(['task', 'conveyor', 'index', 'loader', 'packer', 'station_2', 'Pick1'])
SERVERS = st.builds(
    server,
    st.lists(NAMES, min_size=1, max_size=3).map(lambda parts: '/' + '/'.join(parts)),
    st.sampled_from([*(kind.name for kind in (*ACTIONS, LAZY, MUTE)), 'strange/action/Thing']),
)


@given(st.integers(1, 5), st.lists(SERVERS, unique_by=lambda device: device.action, max_size=7))
def test_whatever_is_found_the_files_fit_each_other(
    sections: int, servers: list[FoundServer]
) -> None:
    read(texts(sections, servers))
