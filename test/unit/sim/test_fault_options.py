"""Faults given on the command line, for a whole cell."""

from __future__ import annotations

import pytest
from fakes.action_types import FakeActionTypes
from fakes.script_texts import CELL

from bt_orchestrator.model.fault import Fault, FaultKind
from bt_orchestrator.script.cell_file import parse_cell
from bt_orchestrator.sim.faults import WrongFaults, with_faults

TYPES = FakeActionTypes()
BARE = parse_cell(CELL, 'cell.yaml', TYPES)


def test_faults_add_to_those_of_the_component() -> None:
    once = with_faults(BARE, ['press.TASK_A=abort'], TYPES)
    twice = with_faults(once, ['press.#2=mute'], TYPES)

    both = (Fault(FaultKind.ABORT, 'TASK_A'), Fault(FaultKind.MUTE, nth=2))
    assert twice.components['press'].faults == both
    assert BARE.components['press'].faults == ()


def test_conveyor_fault_applies_to_both_component_entries() -> None:
    cell = with_faults(BARE, ['conveyor=hang'], TYPES)

    assert cell.conveyor.component.faults == (Fault(FaultKind.HANG),)
    assert cell.components['conveyor'] is cell.conveyor.component


def test_all_mistakes_are_told_at_once() -> None:
    with pytest.raises(WrongFaults) as refused:
        with_faults(BARE, ['pres=abort', 'press=hang', 'cart=false'], TYPES)

    unknown, unseen = str(refused.value).splitlines()
    assert unknown.endswith('no component `pres` in cell `test_cell`; did you mean `press`?')
    assert unseen.startswith('--fail cart=false: the Result of nav_interfaces/action/DriveTo has')


def test_both_mistakes_of_one_option_are_told() -> None:
    with pytest.raises(WrongFaults) as refused:
        with_faults(BARE, ['press.TSK_A=not_ready'], TYPES)

    task, state = str(refused.value).splitlines()
    assert task.endswith('has no task `TSK_A`; did you mean `TASK_A`?')
    assert 'has no state topic' in state
