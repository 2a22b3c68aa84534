"""Why nothing moves in a cell: one cause, from a closed list (semantics 7.4)."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


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
