"""The recipe and the cell of the reference process, as facts (`trees/reference_process.yaml`)."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from fakes.action_types import FakeActionTypes

from bt_orchestrator.model.capability import Capability, Preparation
from bt_orchestrator.model.cell import Cell, OnFailure
from bt_orchestrator.model.recipe import Operation, Recipe
from bt_orchestrator.model.reference import Reference, Template
from bt_orchestrator.model.script import Parameter
from bt_orchestrator.script.cell_file import read_cell

ROOT = Path(__file__).parents[2]

CAPABILITIES = {
    'unpacking_arm': (
        Capability(
            'take_from_case', 'PICK_FROM_CASE', options={'requires_conveyor': False, 'retries': 2}
        ),
        Capability('put_on_belt', 'PLACE_AT_CONVEYOR', options={'qty_change': 1}),
    ),
    'component_1a': (Capability('drill', 'TASK_A'),),
    'component_2a': (Capability('deburr', 'TASK_A'),),
    'component_3a': (Capability('insert', 'TASK_A'),),
    'component_3b': (
        Capability('print_label', 'TASK_A', parameters={'text': 'special_argument_1'}),
        Capability('apply_label', 'TASK_B'),
    ),
    'component_3c': (Capability('read_label', 'TASK_A', gives={'label_ok': 'item_present'}),),
    'packing_arm': (Capability('put_into_box', 'PICK_AND_PACK', options={'qty_change': -1}),),
}

PREPARATIONS = {
    'conveyor': Preparation('home_belt', 'HOME', options={'once': True}),
    'unpacking_arm': Preparation('prepare_unpacking', 'PREPARE', after=('conveyor',)),
    'packing_arm': Preparation('prepare_packing', 'PREPARE'),
}


def deck_cell() -> Cell:
    """Return the reference cell, and what its components can do."""
    cell = read_cell(ROOT / 'config' / 'reference_cell.yaml', FakeActionTypes())
    components = {
        name: replace(
            one,
            capabilities={can.name: can for can in CAPABILITIES.get(name, ())},
            prepare=PREPARATIONS.get(name),
        )
        for name, one in cell.components.items()
    }
    conveyor = replace(cell.conveyor, component=components['conveyor'])
    return replace(cell, components=components, conveyor=conveyor)


def deck_recipe() -> Recipe:
    """Return the recipe WM-100."""
    label = Template((Reference('params', 'label'),))
    written: tuple[tuple[str, str, dict[str, Any]], ...] = (
        ('pick', 'take_from_case', {}),
        ('place', 'put_on_belt', {}),
        ('drill', 'drill', {}),
        ('deburr', 'deburr', {'options': {'on_failure': OnFailure.CONTINUE}}),
        ('insert', 'insert', {}),
        ('label', 'print_label', {'parameters': {'text': label}}),
        ('stick', 'apply_label', {}),
        ('read', 'read_label', {}),
        ('pack', 'put_into_box', {}),
    )
    operations: list[Operation] = []
    for name, do, more in written:
        after = tuple(one.id for one in operations[-1:])
        operations.append(Operation(name, (do,), after, **more))
    params = {'label': Parameter('label', 'str', 'none', required=False)}
    return Recipe('WM-100', 1, 'reference_process', tuple(operations), params)
