"""Numbers and texts of ISA-95 Job Control: states of a job, and return values of its methods."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import IntFlag

from bt_orchestrator.model.jobs.isa95 import JobWord


@dataclass(frozen=True)
class State:
    """ISA95StateDataType: a state of the job order, or of one of its sub-state machines."""

    text: str
    number: int
    machine: str = ''
    """Browse name of the sub-state machine; empty: it is the state of the order itself."""


STATE_NUMBERS: Mapping[str, int] = {
    'NotAllowedToStart': 1,
    'AllowedToStart': 2,
    'Running': 3,
    'Interrupted': 4,
    'Ended': 5,
    'Aborted': 6,
}
"""StateNumber of the states of ISA95JobOrderReceiverSubStatesType."""

SUBSTATES: Mapping[str, Mapping[str, int]] = {
    'Interrupted': {'Held': 1, 'Suspended': 2},
    'AllowedToStart': {'Waiting': 1},
}
"""StateNumber of the substates that a cell tells, by their state."""

WAITING = 'Waiting'
"""The substate of a job that is AllowedToStart and waits for its StartTime."""

_MACHINE = 'Substates'
"""A sub-state machine is named after its state."""

MACHINES = tuple(state + _MACHINE for state in SUBSTATES)
"""Names of the sub-state machines."""


def states_of(word: JobWord, *, awaits_start: bool = False) -> tuple[State, ...]:
    """Return the state of a job and, behind it, its substate if it has one."""
    top = State(word.state, STATE_NUMBERS[word.state])
    is_waiting = awaits_start and word is JobWord.ALLOWED_TO_START
    substate = WAITING if is_waiting else word.substate
    if not substate:
        return (top,)
    number = SUBSTATES[word.state][substate]
    return (top, State(substate, number, word.state + _MACHINE))


def has_all(states: Sequence[State], wanted: Sequence[State]) -> bool:
    """Tell whether a job with some states has all that are asked for.

    A state is known by its number, or by its text where that is 0.
    """
    return all(any(_is(state, other) for state in states) for other in wanted)


def are_known(wanted: Sequence[State]) -> bool:
    """Tell whether a job can have all of these states."""
    return any(
        has_all(states_of(word, awaits_start=awaits), wanted)
        for word in JobWord
        for awaits in (False, True)
    )


def _is(state: State, wanted: State) -> bool:
    if bool(state.machine) != bool(wanted.machine):
        return False
    return state.number == wanted.number if wanted.number else state.text == wanted.text


# The return values of the methods of ISA-95 Job Control (OPC 10031-4, annex B.2).


class ReturnStatus(IntFlag):
    """A bit map; a call that did what was asked returns DONE alone."""

    DONE = 1
    """The request is done."""
    UNKNOWN_ID = 2
    """There is no such job order."""
    WRONG_STATE = 8
    """The method is not for a job order in its state."""
    NOT_ACCEPTED = 16
    """The order cannot be taken: refused, a duplicate, or the cell is full."""
    MALFORMED = 4294967296
    """The request cannot be understood."""


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong with a request."""

    where: str
    """The field, as JobOrderParameters.RunsPlanned."""
    what: str
    """The expected and the found value."""
    status: ReturnStatus = ReturnStatus.NOT_ACCEPTED

    def __str__(self) -> str:
        return f'{self.where}: {self.what}'


class Unfit(ValueError):
    """A request with findings, which is not sent to the cell."""

    def __init__(self, findings: tuple[Finding, ...]) -> None:
        super().__init__('; '.join(map(str, findings)))
        self.findings = findings

    @property
    def status(self) -> ReturnStatus:
        """All findings together."""
        status = ReturnStatus(0)
        for finding in self.findings:
            status |= finding.status
        return status
