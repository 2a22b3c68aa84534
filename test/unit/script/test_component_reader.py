"""Components of a cell file, and the conveyor."""

from __future__ import annotations

import pytest
from fakes.action_types import FakeActionTypes
from fakes.mistake_tables import table
from fakes.mistake_texts import BELT, COMPONENT, NAMED
from fakes.script_texts import mistakes

from bt_orchestrator.model.cell import Cell, OnFailure
from bt_orchestrator.model.fault import Fault, FaultKind
from bt_orchestrator.script.cell_file import parse_cell


def parsed(text: str) -> Cell:
    return parse_cell(text, 'cell.yaml', FakeActionTypes())


def arm(options: str) -> str:
    return COMPONENT.format(NAMED + options)


@pytest.mark.parametrize(('names', 'expected'), table('component_names'))
def test_names(names: str, expected: list[str]) -> None:
    assert mistakes(lambda: parsed(COMPONENT.format(names))) == expected


@pytest.mark.parametrize(('options', 'expected'), table('component_options'))
def test_options(options: str, expected: list[str]) -> None:
    assert mistakes(lambda: parsed(arm(options))) == expected


@pytest.mark.parametrize(('options', 'expected'), table('conveyor'))
def test_the_conveyor(options: str, expected: list[str]) -> None:
    assert mistakes(lambda: parsed(BELT.format(options))) == expected


def test_simulated_behaviour_is_read() -> None:
    options = 'durations: {RUN: 2, STOP: 0}, results: {RUN: {value: 2, pose: {frame: x}}}'
    component = parsed(arm(options)).components['arm']
    assert (component.duration_s('RUN'), component.duration_s('STOP')) == (2.0, 0.0)
    assert component.duration_s('OTHER') == 1.0
    assert component.results == {'RUN': {'value': 2.0, 'pose': {'frame': 'x'}}}


def test_faults_of_the_simulated_controller_are_read() -> None:
    component = parsed(arm('faults: [RUN=abort, "#2=late:3.5"]')).components['arm']
    late = Fault(FaultKind.LATE, nth=2, seconds=3.5)
    assert component.faults == (Fault(FaultKind.ABORT, 'RUN'), late)


def test_the_conveyor_may_have_faults() -> None:
    options = 'sections: 3, type: plain_interfaces/action/Index, faults: ["#1=hang"]'
    assert parsed(BELT.format(options)).conveyor.component.faults == (Fault(FaultKind.HANG),)


def test_component_needs_only_name_and_type() -> None:
    component = parsed(arm('')).components['arm']
    assert (component.sections, component.state, component.results) == ((), None, {})
    assert component.durations_s == {}


def test_the_conveyor_may_retry_and_abort() -> None:
    options = 'sections: 3, type: plain_interfaces/action/Index, retries: 2, duration: 4, '
    belt = parsed(BELT.format(options + 'on_failure: abort_job')).conveyor
    assert (belt.retries, belt.on_failure) == (2, OnFailure.ABORT_JOB)
    assert belt.component.duration_s('anything') == 4.0


def test_index_task_without_task_field_is_a_label() -> None:
    options = 'sections: 3, type: plain_interfaces/action/Index'
    assert parsed(BELT.format(options)).conveyor.task == 'Index'
    assert parsed(BELT.format(options + ', task: GO')).conveyor.task == 'GO'
