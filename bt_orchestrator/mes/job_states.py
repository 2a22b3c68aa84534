"""The state of a job as ISA-95 Job Control tells it: texts and numbers, with the substate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from bt_orchestrator.model.jobs.isa95 import JobWord


@dataclass(frozen=True)
class State:
    """ISA95StateDataType: a state of the job order, or of one of its sub-state machines."""

    text: str
    number: int
    machine: str = ''
    """Browse name of the sub-state machine; empty: it is the state of the order itself."""


NUMBERS: Mapping[str, int] = {
    'NotAllowedToStart': 1,
    'AllowedToStart': 2,
    'Running': 3,
    'Interrupted': 4,
    'Ended': 5,
    'Aborted': 6,
}
"""StateNumber of the states of ISA95JobOrderReceiverSubStatesType."""

SUBSTATES: Mapping[str, Mapping[str, int]] = {'Interrupted': {'Held': 1, 'Suspended': 2}}
"""StateNumber of the substates that a cell tells, by their state."""

_MACHINE = 'Substates'
"""A sub-state machine is named after its state."""


def states_of(word: JobWord) -> tuple[State, ...]:
    """Return the state of a job and, behind it, its substate if it has one."""
    top = State(word.state, NUMBERS[word.state])
    if not word.substate:
        return (top,)
    number = SUBSTATES[word.state][word.substate]
    return (top, State(word.substate, number, word.state + _MACHINE))


def words_in(states: Sequence[State]) -> frozenset[JobWord]:
    """Return the words of a job that have all of these states; empty: nothing is known by them.

    A state is known by its number, or by its text where that is 0.
    """
    if not states:
        return frozenset()
    return frozenset(
        word for word in JobWord if all(_has(states_of(word), wanted) for wanted in states)
    )


def _has(states: Sequence[State], wanted: State) -> bool:
    return any(
        bool(one.machine) == bool(wanted.machine)
        and (one.number == wanted.number if wanted.number else one.text == wanted.text)
        for one in states
    )
