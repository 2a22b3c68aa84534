"""Why something waits, and why nothing moves: in words for people, and as data (semantics 7.4)."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from bt_orchestrator.model.frozen import made_at_once


class WaitKind(Enum):
    """The cause of a wait."""

    BELT = 'belt'
    """The belt has to move, or to come to rest."""
    TURN = 'turn'
    """Sections have to complete their turns."""
    ITEM = 'item'
    """An item has to come, or something to put on the empty belt."""
    JOB = 'job'
    """There is no work, or a section has to be done with an earlier job."""
    FLAG = 'flag'
    """A lateral dependency has to allow it."""
    ZONE = 'zone'
    """A task is in it."""
    COMPONENT = 'component'
    """Another task has it."""
    READINESS = 'readiness'
    """A component does not report ready, or is contested."""
    OUT_OF_SERVICE = 'out_of_service'
    """An operator took a component out of service."""
    INITIALIZATION = 'initialization'
    """Initialization tasks have to be done first."""
    HOLD = 'hold'
    """An operator has to answer."""
    PAUSE = 'pause'
    """The cell, or a job, has to be resumed."""
    RETRY_DELAY = 'retry_delay'
    """The time before another attempt has to pass."""
    CELL_STATE = 'cell_state'
    """The cell is in a state in which nothing starts."""


GRAVE = (
    WaitKind.HOLD,
    WaitKind.OUT_OF_SERVICE,
    WaitKind.READINESS,
    WaitKind.PAUSE,
    WaitKind.RETRY_DELAY,
    WaitKind.CELL_STATE,
)
"""Waits that end outside of the line, the gravest first; all others end when these do."""


@made_at_once
@dataclass(frozen=True)
class Wait:
    """Why something does not begin, naming what it waits for."""

    reason: str
    """The sentence that people read."""
    kind: WaitKind
    name: str = ''
    """Name of the flag, zone, component, initialization task, job, hold or item; empty if the kind
    says it all."""
    sections: tuple[int, ...] = ()
    """Sections that have to do something first."""
    task: str = ''
    """The task that has to do something first."""
    components: tuple[str, ...] = ()
    """The blocked components."""
    holds: tuple[str, ...] = ()
    """Where several holds have to be answered: all of them."""

    def __str__(self) -> str:
        return self.reason


INITIALIZATION = 'initialization'
BELT = 'belt'


@dataclass(frozen=True)
class PartWait:
    """One part of the cell and what it waits for."""

    part: str
    """initialization, section N, belt, or a component."""
    wait: Wait
    section: int | None = None
    """The section, if it is one."""

    @property
    def reason(self) -> str:
        """The cause of its wait, in words."""
        return self.wait.reason

    def __str__(self) -> str:
        return f'{self.part}: {self.wait}'


# Why nothing moves in a cell: one cause, from a closed list (semantics 7.4).


class StandCause(Enum):
    """The root cause of a standstill."""

    JOURNAL = 'journal'
    """The journal failed, or the disk has not taken what was written."""
    COMMAND = 'command'
    """The cell was stopped or aborted, or was not started: it waits for a command."""
    HOLD = 'hold'
    """A task, an item or the cell is held: an operator has to answer."""
    PAUSE = 'pause'
    """A person paused the cell or a job."""
    OUT_OF_SERVICE = 'out_of_service'
    """A component is out of service."""
    CONTESTED = 'contested'
    """An action has several servers, or runs a goal of another client."""
    STARVED = 'starved'
    """The source is not ready."""
    BLOCKED = 'blocked'
    """The sink is not ready."""
    NOT_READY = 'not_ready'
    """Another component is not ready."""
    RETRY_DELAY = 'retry_delay'
    """The time before another attempt has not passed."""
    RELEASE = 'release'
    """Jobs wait for the release of their script."""
    JOB_HELD = 'job_held'
    """Jobs wait until a person releases them."""
    JOB_START = 'job_start'
    """Jobs wait for the start of their orders."""
    ORDER = 'order'
    """There is no job."""
    OTHER = 'other'
    """Something else, which the reason names."""


@dataclass(frozen=True)
class Stands:
    """Why no goal runs in a cell and none can start."""

    since: float
    """When that began."""
    cause: StandCause
    """journal, command, hold, pause, out_of_service, contested, starved, blocked, not_ready,
    retry_delay, release, job_held, job_start, order or other."""
    reason: str
    """The sentence that people read."""
    name: str = ''
    """Name of the hold, component, job or task that is the cause; empty: the cause says it all."""
    sections: tuple[int, ...] = ()
    """Where the cause is."""
    components: tuple[str, ...] = ()
    """Components that the cause is about."""
