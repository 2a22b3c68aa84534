"""The state of a job in the words of ISA-95 Job Control (semantics 7.2)."""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum
from typing import Protocol

from bt_orchestrator.model.state import CellState, JobState
from bt_orchestrator.model.stop_reason import WORDS, Interruption, StopReason


class JobWord(Enum):
    """State of a job; the two kinds of Interrupted are substates."""

    NOT_ALLOWED_TO_START = 'NotAllowedToStart'
    """It waits in the queue, and others pass it."""
    ALLOWED_TO_START = 'AllowedToStart'
    """It waits in the queue for its turn."""
    RUNNING = 'Running'
    HELD = 'Interrupted/Held'
    """Something on the line went wrong."""
    SUSPENDED = 'Interrupted/Suspended'
    """An operator wished so."""
    ENDED = 'Ended'
    ABORTED = 'Aborted'

    @property
    def state(self) -> str:
        """The state without its substate."""
        return self.value.partition('/')[0]

    @property
    def substate(self) -> str:
        """Held or Suspended; empty where there is none."""
        return self.value.partition('/')[2]


OVER = (JobWord.ENDED, JobWord.ABORTED)
"""States of a job that does not go on."""

QUEUED = (JobWord.NOT_ALLOWED_TO_START, JobWord.ALLOWED_TO_START)
"""States of a job that has not started."""

_OF_INTERRUPTION = {
    Interruption.HELD: JobWord.HELD,
    Interruption.SUSPENDED: JobWord.SUSPENDED,
}


def job_word(state: CellState, job: JobState) -> JobWord:
    """Derive the state of a job: what stops the line interrupts every job on it."""
    if job.ended_at is not None:
        return JobWord.ABORTED if job.aborting else JobWord.ENDED
    if not job.started:
        return queued_word(job)
    return word_at_work(state.stop_reason, is_paused=job.paused)


class Passed(Protocol):
    """The reason for which the queue passes a job, in the state and in events."""

    @property
    def held(self) -> bool:
        """A person keeps it from starting (semantics 6.6)."""

    @property
    def awaits_release(self) -> bool:
        """Its script is not released (semantics 6.10)."""

    @property
    def unavailable(self) -> Sequence[str]:
        """Components out of service that it needs (semantics 7.5)."""


def queued_word(job: Passed) -> JobWord:
    """Derive the state of a job in the queue; its start is waited for in AllowedToStart."""
    passed = job.held or job.awaits_release or job.unavailable
    return JobWord.NOT_ALLOWED_TO_START if passed else JobWord.ALLOWED_TO_START


def word_at_work(stop_reason: StopReason | None, *, is_paused: bool) -> JobWord:
    """Derive the state of a job on the line.

    :param stop_reason: why the line stands still; None: it does not
    """
    if is_paused:
        return JobWord.SUSPENDED
    if stop_reason is None:
        return JobWord.RUNNING
    return _OF_INTERRUPTION[WORDS[stop_reason].job]
