"""The state of a job in the words of ISA-95 Job Control (semantics 7.2)."""

from __future__ import annotations

from enum import Enum

from bt_orchestrator.model.state import CellState, JobState


class JobWord(Enum):
    """State of a job."""

    ALLOWED_TO_START = 'AllowedToStart'
    RUNNING = 'Running'
    INTERRUPTED = 'Interrupted'
    ENDED = 'Ended'
    ABORTED = 'Aborted'


def job_word(state: CellState, job: JobState) -> JobWord:
    """Derive the state of a job: a hold anywhere interrupts every job on the line."""
    if job.ended_at is not None:
        return JobWord.ABORTED if job.aborting else JobWord.ENDED
    if not job.started:
        return JobWord.ALLOWED_TO_START
    return JobWord.INTERRUPTED if state.holds else JobWord.RUNNING
