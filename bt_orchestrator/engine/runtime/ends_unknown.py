"""Why the end of a job cannot be expected: somebody has to do something first."""

from __future__ import annotations

from itertools import takewhile

from bt_orchestrator.engine.runtime.stands import obstacles
from bt_orchestrator.model.hold_words import hold_wait_words
from bt_orchestrator.model.jobs.needs import awaited_by
from bt_orchestrator.model.stands import StandCause, Stands
from bt_orchestrator.model.state import CellState, JobState

_KNOWN = (StandCause.RETRY_DELAY, StandCause.JOB_START)
"""Causes of a standstill whose end is known."""


class Unknown:
    """Says for each job of one status why its end is unknown."""

    def __init__(self, state: CellState, stands: Stands | None) -> None:
        """Look at what keeps all jobs.

        :param stands: why the cell stands; None: something moves
        """
        self._state = state
        self._of_all = _of_all(state, stands)

    def why(self, job: JobState) -> str:
        """Say why the end of a job is unknown; empty: nothing speaks against it."""
        if job.ended_at is not None:
            return ''
        return self._of_all or self._of_job(job) or self._of_those_before(job)

    def _of_job(self, job: JobState) -> str:
        name = job.job.id
        if job.started:
            lacks = ' and '.join(awaited_by(self._state, job))
            if job.paused and job.cycles_left:
                return f'{name} is paused'
            return f'{name} needs {lacks}, which is out of service' if lacks else ''
        return '; '.join(
            f'{name} {words}' for cause, words in obstacles(job) if cause not in _KNOWN
        )

    def _of_those_before(self, job: JobState) -> str:
        """Say what keeps a job on the line before this one."""
        before = takewhile(lambda one: one is not job, self._state.jobs.line.values())
        return next(filter(None, map(self._of_job, before)), '')


def _of_all(state: CellState, stands: Stands | None) -> str:
    if stands is not None and stands.cause is StandCause.JOURNAL:
        return stands.reason
    if stands is not None and state.has_work and stands.cause not in _KNOWN:
        return stands.reason
    if state.holds:
        return hold_wait_words(state.holds.values())
    if state.stopped_by is not None:
        return f'{state.stopped_by}'
    return ''
