"""Jobs that wait for the start of their order (semantics 6.7)."""

from __future__ import annotations

from collections.abc import Iterator

from bt_orchestrator.base.deadlines import has_come
from bt_orchestrator.engine.runtime.ledger import Ledger
from bt_orchestrator.engine.runtime.wall_clock import STEP_S
from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import Cell, Start
from bt_orchestrator.model.jobs.order import Terms


def awaits_start(cell: Cell, terms: Terms, now: float) -> bool:
    """Tell whether a job has to wait for the start of its order."""
    if terms.start is None or cell.start is Start.ADVISORY:
        return False
    return not has_come(terms.start, now)


class Starts:
    """Lets jobs start when their time has come, at every settle.

    A start is a time of the calendar, so the wall clock decides, also one that was set. The timer
    on the steady clock only causes a settle at that time.
    """

    def __init__(self, ledger: Ledger) -> None:
        self._ledger = ledger
        self._wakes_at = 0.0
        """On the steady clock."""

    def land(self) -> None:
        """Record the jobs that may start now, and be woken for the next one."""
        jobs = self._ledger.state.jobs
        if jobs.first_awaiting is not None:
            self._ledger.record(self._due())
        first = jobs.first_awaiting
        if first is None:
            return
        start, steady = first.job.terms.start, self._ledger.steady
        assert start is not None
        wake_at = steady + start - self._ledger.now
        if has_come(self._wakes_at, steady) or abs(wake_at - self._wakes_at) >= STEP_S:
            self._wakes_at = wake_at
            self._ledger.wake_at(wake_at)

    def _due(self) -> Iterator[e.JobMayStart]:
        state, now = self._ledger.state, self._ledger.now
        while (job := state.jobs.first_awaiting) is not None:
            if awaits_start(state.cell, job.job.terms, now):
                return
            yield e.JobMayStart(job=job.job.id)
