"""Choosing components and faults on the command line."""

from __future__ import annotations

import pytest

from bt_orchestrator.base.errors import UnknownActionType
from bt_orchestrator.model.action_type import ActionType, FieldType, MessageType
from bt_orchestrator.model.cell import Cell, Component, Conveyor, StateTopic
from bt_orchestrator.model.fault import Fault, FaultKind
from bt_orchestrator.sim.controllers.options import WrongSelection, controller_names, select

BOOL = FieldType('bool', 'boolean')
TASK = FieldType('int', 'uint8')
TYPES = {
    'p/action/Arm': ActionType(
        'p/action/Arm',
        MessageType('Goal', {'task': TASK}),
        MessageType('Result', {'task_result': BOOL}),
        {'TASK_A': 1, 'GRIND': 2},
    ),
    'p/action/Count': ActionType(
        'p/action/Count', MessageType('Goal', {}), MessageType('Result', {})
    ),
}
ARM = Component(
    'arm', (1,), '/arm/task', 'p/action/Arm', StateTopic('/arm/state', 'p/msg/S', 'data', (1,))
)
COUNTER = Component('counter', (1,), '/counter/count', 'p/action/Count')
BELT = Component('conveyor', (), '/conveyor/index', 'p/action/Arm')
CELL = Cell('c', Conveyor(2, BELT, 'TASK_A'), {c.name: c for c in (BELT, ARM, COUNTER)})


class KnownTypes:
    """Implements `ports.ActionTypes` for the two types of this file."""

    def action(self, name: str) -> ActionType:
        return TYPES[name]

    def message_field(self, type_name: str, field: str) -> str:
        raise UnknownActionType(type_name, 'no messages here', 'none needed')


def chosen(*only: str, fail: tuple[str, ...] = ()) -> dict[str, tuple[Fault, ...]]:
    return {c.name: c.faults for c in select(CELL, only, fail, KnownTypes())}


def complaint(*only: str, fail: tuple[str, ...] = ()) -> str:
    with pytest.raises(WrongSelection) as refused:
        chosen(*only, fail=fail)
    return str(refused.value)


def test_all_components_are_simulated_in_file_order() -> None:
    assert list(chosen()) == ['conveyor', 'arm', 'counter']


def test_only_named_components_are_simulated_including_conveyor() -> None:
    assert list(chosen('counter', 'conveyor')) == ['conveyor', 'counter']


def test_names_are_separated_by_commas_or_given_apart() -> None:
    assert list(controller_names(['a, b', 'c', ''])) == ['a', 'b', 'c']


@pytest.mark.parametrize(
    ('text', 'fault'),
    [
        ('arm.TASK_A#2=abort', Fault(FaultKind.ABORT, 'TASK_A', 2)),
        ('arm.#3=die:5', Fault(FaultKind.DIE, None, 3, 5.0)),
        ('arm#3=die:5', Fault(FaultKind.DIE, None, 3, 5.0)),
        ('arm=hang', Fault(FaultKind.HANG)),
        ('arm.GRIND=late:1.5', Fault(FaultKind.LATE, 'GRIND', seconds=1.5)),
        (' arm.=silent ', Fault(FaultKind.SILENT, nth=0)),
    ],
)
def test_fault_is_read_after_component_name(text: str, fault: Fault) -> None:
    assert chosen(fail=(text,))['arm'] == (fault,)


def test_faults_add_to_each_other() -> None:
    assert len(chosen(fail=('arm#1=abort', 'arm#2=abort'))['arm']) == 2


@pytest.mark.parametrize(
    ('text', 'what'),
    [
        ('amr=abort', 'no component `amr` in cell `c`; did you mean `arm`?'),
        ('arm.TASKA=abort', 'p/action/Arm has no task `TASKA`; did you mean `TASK_A`?'),
        ('arm.XYZ=abort', 'p/action/Arm has no task `XYZ`; its tasks are `TASK_A`, `GRIND`'),
        ('arm=explode', "unknown fault 'explode'; one of false, "),
        (
            'arm',
            'a fault is written [TASK][#NTH]=KIND[:SECONDS]',
        ),
        ('=abort', 'expected COMPONENT.FAULT, as in arm.TASK_A#2=abort'),
        ('counter=silent', 'component `counter` has no state topic in the cell file'),
        ('counter=false', 'the Result of p/action/Count has no field `task_result`'),
        ('counter.COUNT=abort', 'p/action/Count has no task field, '),
    ],
)
def test_impossible_fault_is_refused(text: str, what: str) -> None:
    assert complaint(fail=(text,)).startswith(f'--fail {text}: {what}')


def test_fault_of_unselected_component_is_refused() -> None:
    assert 'add it to --only' in complaint('counter', fail=('arm=abort',))


def test_all_mistakes_are_told_at_once() -> None:
    assert len(complaint('amr', 'counter', fail=('arm', 'counter=silent')).splitlines()) == 3
