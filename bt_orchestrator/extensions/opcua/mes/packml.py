"""PackML in numbers (ISA-TR88.00.02 and OPC 30050): states, nested state machines, commands."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from enum import Enum
from typing import NamedTuple

from bt_orchestrator.model.packml import Cause, PackmlState
from bt_orchestrator.model.requests import About, Request, requests_about

STATE_NUMBERS: Mapping[PackmlState, int] = {
    PackmlState.CLEARING: 1,
    PackmlState.STOPPED: 2,
    PackmlState.STARTING: 3,
    PackmlState.IDLE: 4,
    PackmlState.SUSPENDED: 5,
    PackmlState.EXECUTE: 6,
    PackmlState.STOPPING: 7,
    PackmlState.ABORTING: 8,
    PackmlState.ABORTED: 9,
    PackmlState.HOLDING: 10,
    PackmlState.HELD: 11,
    PackmlState.UNHOLDING: 12,
    PackmlState.SUSPENDING: 13,
    PackmlState.UNSUSPENDING: 14,
    PackmlState.RESETTING: 15,
    PackmlState.COMPLETING: 16,
    PackmlState.COMPLETE: 17,
}
"""StateNumber of the nodeset, which is StateCurrent of PackML."""

PRODUCE = 1
"""The only unit mode: the cell has no maintenance or manual mode of its own."""


class Machine(Enum):
    """The nested state machines of the nodeset, outermost first; values are their browse paths."""

    BASE = 'BaseStateMachine'
    MACHINE = 'BaseStateMachine/MachineState'
    EXECUTE = 'BaseStateMachine/MachineState/ExecuteState'


CLEARED, RUNNING = 'Cleared', 'Running'
"""The states of the outer machines in which the machine inside is active."""

NUMBERS: Mapping[str, int] = {
    **{state.value: number for state, number in STATE_NUMBERS.items()},
    RUNNING: 18,
    CLEARED: 19,
}
"""StateNumber of every state of the machines, by name."""

_ABORTED = (PackmlState.ABORTING, PackmlState.ABORTED)
_NOT_RUNNING = (PackmlState.CLEARING, PackmlState.STOPPED, PackmlState.STOPPING)


def states_in(state: PackmlState) -> Mapping[Machine, str]:
    """Return the state of each nested machine that is active."""
    if state in _ABORTED:
        return {Machine.BASE: state.value}
    if state in _NOT_RUNNING:
        return {Machine.BASE: CLEARED, Machine.MACHINE: state.value}
    return {Machine.BASE: CLEARED, Machine.MACHINE: RUNNING, Machine.EXECUTE: state.value}


class MachineTransition(NamedTuple):
    """A transition of one nested machine, with the names of the nodeset."""

    machine: Machine
    before: str
    after: str

    @property
    def name(self) -> str:
        """Its browse name."""
        return f'{self.before}To{self.after}'


def transitions_between(before: PackmlState, after: PackmlState) -> Iterator[MachineTransition]:
    """Yield the transitions of the machines; one that begins or ends with it has none."""
    old, new = states_in(before), states_in(after)
    for machine in Machine:
        if machine in old and machine in new and old[machine] != new[machine]:
            yield MachineTransition(machine, old[machine], new[machine])


COMMANDS: Mapping[str, Request] = {
    one.cause.value.capitalize(): one
    for one in requests_about(About.CELL)
    if one.cause is not None and one.cause is not Cause.CLEAR
}
"""Methods of the nodeset, and what they ask of the cell."""

_HELD = (PackmlState.HOLDING, PackmlState.HELD)


def command_fault(name: str, state: PackmlState) -> str | None:
    """Say why PackML has no such command in a state where the cell would take it; None: it has.

    Pauses of the cell stack (semantics 7.3), PackML's Hold does not.
    """
    if name != 'Hold' or state not in _HELD:
        return None
    return (
        f'the cell is {state.value} already; Simple/Command with `pause` adds a pause, which '
        'keeps it from going on until it is released'
    )


CLEAR_AS_SHOWN = 'ClearAsShown'
"""Our method for `clear`: PackML's Clear cannot say what stands on the belt."""

WITHOUT: Mapping[str, str] = {
    'Clear': f'it cannot say what stands on the belt: {CLEAR_AS_SHOWN} does',
    'ToComplete': 'the cell completes by itself when the last job has ended',
    'Suspend': 'the cell suspends by itself when its source or sink is not ready',
    'Unsuspend': 'the cell goes on by itself',
}
"""Methods of the nodeset that the cell does not have, and why."""
