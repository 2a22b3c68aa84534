"""PackML in numbers (ISA-TR88.00.02, OPC 30050): states, commands, and the values of a cell."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from bt_orchestrator.extensions.opcua.mes.alarms import NONE, StopId, deciding_hold, id_of_stop
from bt_orchestrator.model.events import BeltIndexed, CellStateChanged, ClockStepped, Event
from bt_orchestrator.model.jobs.isa95 import OVER
from bt_orchestrator.model.packml import TRANSITIONS, Cause, PackmlState, UnitMode
from bt_orchestrator.model.requests import About, Request, requests_about
from bt_orchestrator.model.status import CellStatus, JobStatus
from bt_orchestrator.model.stop_reason import StopReason

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

MODE_NUMBERS: Mapping[UnitMode, int] = {UnitMode.PRODUCTION: PRODUCE, UnitMode.MANUAL: 3}
"""UnitModeCurrent of PackML; the cell has no maintenance mode, which is 2."""

MODE_NAMES: Mapping[int, str] = {PRODUCE: 'Produce', 3: 'Manual'}


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
    request.cause.value.capitalize(): request
    for request in requests_about(About.CELL)
    if request.cause is not None and request.cause is not Cause.CLEAR
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

PRODUCE_AS_SHOWN = 'ProduceAsShown'
"""Our method for the end of manual mode, which SetUnitMode cannot be for the same reason."""

WITHOUT: Mapping[str, str] = {
    'Clear': f'it cannot say what stands on the belt: {CLEAR_AS_SHOWN} does',
    'ToComplete': 'the cell completes by itself when the last job has ended',
    'Suspend': 'the cell suspends by itself when its source or sink is not ready',
    'Unsuspend': 'the cell goes on by itself',
}
"""Methods of the nodeset that the cell does not have, and why."""


# The values of a cell in PackML's Status and Admin, as far as they are known.


@dataclass(frozen=True)
class Stop:
    """Why the line stands still: PackML's StopReason."""

    reason: StopId = NONE
    hold: int = 0
    """Number of the hold that decides it; 0: none does."""
    message: str = ''
    since: float | None = None
    """Seconds since the epoch; None: it does not stand still."""


@dataclass(frozen=True)
class PackmlValues:
    """One status in PackML's words; times are whole seconds, by state number."""

    state: int
    is_changing: bool
    """It is in an acting state, which ends by itself."""
    in_state_s: Mapping[int, int]
    """Of the present stay."""
    total_s: Mapping[int, int]
    """Since the beginning of the journal."""
    stop: Stop
    is_starved: bool
    is_blocked: bool


def packml_values(status: CellStatus) -> PackmlValues:
    """Return a status in PackML's words."""
    number = STATE_NUMBERS[status.state]
    return PackmlValues(
        state=number,
        is_changing=status.state is not PackmlState.EXECUTE
        and Cause.DONE in TRANSITIONS[status.state],
        in_state_s={number: max(0, int(status.stamp - status.state_since))},
        total_s={STATE_NUMBERS[state]: int(s) for state, s in status.state_times.items()},
        stop=_stop(status),
        is_starved=status.stop_reason is StopReason.STARVED,
        is_blocked=status.stop_reason is StopReason.BLOCKED,
    )


def _stop(status: CellStatus) -> Stop:
    reason = id_of_stop(status)
    if reason is NONE:
        return Stop()
    hold = deciding_hold(status)
    message = status.journal_failure or status.stop_message
    if hold is None or status.journal_failure:
        return Stop(reason, 0, message, status.state_since)
    return Stop(reason, int(hold.id), message, hold.since)


# PackML's counters: items that have left the line, by job and in all.


@dataclass(frozen=True)
class Count:
    """Items of one job."""

    job: str
    """Empty: there was no job yet."""
    processed: int = 0
    """Produced (semantics 6.2)."""
    defective: int = 0
    """Those of them that are not good."""


class Counter:
    """Counts the items that leave the line, from one status to the next, in one journal."""

    def __init__(self) -> None:
        self.processed = 0
        """Of all jobs, those before included that the first status listed."""
        self.defective = 0
        self.counts: Sequence[Count] = (Count(''),)
        """Of the jobs on the line in the order they started, else of the last one that ended."""
        self._known: dict[str, Count] = {}

    def show(self, status: CellStatus) -> None:
        """Count on."""
        counts = {job.id: _count(job) for job in status.jobs if not job.position}
        for name, count in counts.items():
            before = self._known.get(name, Count(name))
            self.processed += max(0, count.processed - before.processed)
            self.defective += max(0, count.defective - before.defective)
        self._known = counts
        begun = [job for job in status.jobs if not job.position]
        shown = [job for job in begun if job.state not in OVER] or begun[-1:]
        self.counts = tuple(counts[job.id] for job in shown) or (Count(''),)


def _count(job: JobStatus) -> Count:
    return Count(job.id, job.produced, job.produced - job.good)


# The speed of the line: how often the belt has moved lately.

MOVES = 10
"""Moves that the speed is the mean of."""


class Speedometer:
    """Hears the moves of the belt since the cell began to execute, in one journal."""

    def __init__(self) -> None:
        self._marks: deque[float] = deque(maxlen=MOVES + 1)
        """Times of moves; the first may be that of the beginning."""

    def hear(self, event: Event) -> None:
        """Take note of an event."""
        if isinstance(event, CellStateChanged):
            self._marks.clear()
            if event.state == PackmlState.EXECUTE.value:
                self._marks.append(event.time)
        elif isinstance(event, BeltIndexed):
            self._marks.append(event.time)
        elif isinstance(event, ClockStepped):
            for at, mark in enumerate(self._marks):
                self._marks[at] = mark + event.seconds

    def a_minute(self, state: PackmlState, now: float) -> float | None:
        """Return the moves a minute; each brings every item one section further.

        None: not known yet, because less than two moves were heard of. It falls while a move is
        overdue, and is 0 in every state in which the belt stands still.
        """
        if state is not PackmlState.EXECUTE:
            return 0.0
        moves = len(self._marks) - 1
        if moves < 1 or self._marks[-1] <= self._marks[0]:
            return None
        took = self._marks[-1] - self._marks[0]
        if_it_moved_now = 60.0 * (moves + 1) / max(now - self._marks[0], took)
        return min(60.0 * moves / took, if_it_moved_now)
