"""PackML's numbers, machines and methods, compared with the nodeset of the OPC Foundation."""

from __future__ import annotations

import pytest
from nodeset_states import Nodeset

from bt_orchestrator.extensions.opcua.mes.packml import (
    COMMANDS,
    NUMBERS,
    STATE_NUMBERS,
    WITHOUT,
    Machine,
    states_in,
    transitions_between,
)
from bt_orchestrator.model.packml import TRANSITIONS, VERBS, Cause, PackmlState

TYPES = {Machine.BASE: 'ns=1;i=3', Machine.MACHINE: 'ns=1;i=2', Machine.EXECUTE: 'ns=1;i=1'}


@pytest.fixture(scope='module')
def pack_ml() -> Nodeset:
    return Nodeset('pack_ml')


def test_the_states_have_the_numbers_of_the_nodeset(pack_ml: Nodeset) -> None:
    assert pack_ml.state_numbers() == NUMBERS
    assert set(STATE_NUMBERS) == set(PackmlState)


@pytest.mark.parametrize('machine', Machine)
def test_each_machine_has_the_transitions_of_its_type(pack_ml: Nodeset, machine: Machine) -> None:
    theirs = {f'{change.before}To{change.after}' for change in pack_ml.transitions(TYPES[machine])}
    ours = {
        change.name
        for before, row in TRANSITIONS.items()
        for after in row.values()
        for change in transitions_between(before, after)
        if change.machine is machine
    }
    assert ours == theirs


@pytest.mark.parametrize(
    ('state', 'expected'),
    [
        (PackmlState.ABORTED, {Machine.BASE: 'Aborted'}),
        (PackmlState.STOPPED, {Machine.BASE: 'Cleared', Machine.MACHINE: 'Stopped'}),
        (
            PackmlState.HELD,
            {Machine.BASE: 'Cleared', Machine.MACHINE: 'Running', Machine.EXECUTE: 'Held'},
        ),
    ],
)
def test_the_machines_are_nested(state: PackmlState, expected: dict[Machine, str]) -> None:
    assert states_in(state) == expected


def test_nodeset_methods_are_commands_or_listed_missing(
    pack_ml: Nodeset,
) -> None:
    methods = {name for type_id in TYPES.values() for name in pack_ml.methods(type_id)}
    assert methods == {*COMMANDS, *WITHOUT}
    for name, request in COMMANDS.items():
        assert request.word == VERBS[Cause(name.lower())]
