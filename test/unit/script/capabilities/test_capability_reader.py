"""Capabilities, workspaces and preparations in a cell file."""

from __future__ import annotations

import pytest
from fakes.action_types import FakeActionTypes
from fakes.mistake_tables import table
from fakes.mistake_texts import COMPONENT, NAMED
from fakes.recipe_texts import able_cell
from fakes.script_texts import mistakes

from bt_orchestrator.model.cell import Capability, Cell, OnFailure, Preparation
from bt_orchestrator.model.reference import Reference, Template
from bt_orchestrator.script.cell_file import parse_cell

PREPARED = """\
cell: c
conveyor: {{sections: 3, action: /belt/index, type: plain_interfaces/action/Index,
  prepare: {{id: {}, after: {}}}}}
components: {{arm: {{action: /arm/task, type: test_interfaces/action/Rich,
  prepare: {{id: ready, task: RUN, after: conveyor}}}}}}
"""


def parsed(text: str) -> Cell:
    return parse_cell(text, 'cell.yaml', FakeActionTypes())


@pytest.mark.parametrize(('options', 'expected'), table('capabilities'))
def test_mistakes(options: str, expected: list[str]) -> None:
    assert mistakes(lambda: parsed(COMPONENT.format(NAMED + options))) == expected


def test_capability_names_some_fields_of_its_task() -> None:
    camera = able_cell().components['camera'].capabilities
    assert camera['mark'] == Capability(
        'mark',
        'RUN',
        args={'name': Template(('item ', Reference('item', 'number')))},
        parameters={'text': 'name', 'at': 'pose'},
        gives={'size': 'code'},
    )
    assert camera['bore'] == Capability('bore', 'STOP', gives={'text': 'code'}, holds={'depth': 1})


def test_need_for_device_property_has_no_field() -> None:
    insert = able_cell().components['press'].capabilities['insert']
    assert insert.needs == {'size': 'special_argument_2', 'depth': ''}


def test_options_are_those_that_were_written() -> None:
    cell = able_cell()
    assert cell.components['loader'].capabilities['put'].options == {'qty_change': 1}
    press = cell.components['table'].capabilities['press']
    assert press.options == {'on_failure': OnFailure.CONTINUE}


def test_a_device_may_read_the_serial() -> None:
    scan = able_cell().components['camera'].capabilities['scan']
    assert scan.options == {'identifies': ('pose', 'frame')}


def test_workspaces_and_preparations_are_read() -> None:
    cell = able_cell()
    assert cell.components['table'].workspaces == ('table',)
    assert cell.components['press'].workspaces == ()
    loader = cell.components['loader'].prepare
    assert loader == Preparation('ready_loader', 'PREPARE', after=('conveyor',))
    belt = cell.conveyor.component.prepare
    assert belt == Preparation('home_belt', 'HOME', options={'once': True})


def test_preparations_that_wait_for_each_other_are_told() -> None:
    assert mistakes(lambda: parsed(PREPARED.format('home', 'arm'))) == [
        '5:42: preparations wait for each other: arm, conveyor, arm; remove one of the waits'
    ]


def test_an_id_of_two_preparations_is_told() -> None:
    assert mistakes(lambda: parsed(PREPARED.format('ready', '[]'))) == [
        '5:17: the id `ready` is given twice; rename one; the first is in line 3'
    ]
