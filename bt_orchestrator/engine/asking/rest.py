"""The order for what a job on the line has not begun (semantics 7.6)."""

from __future__ import annotations

from itertools import chain, count

from bt_orchestrator.base.errors import CommandRefused, NotRead
from bt_orchestrator.engine.runtime.job_queue import allowed
from bt_orchestrator.model.jobs import job_control
from bt_orchestrator.model.jobs.order import order_id_fault
from bt_orchestrator.model.state import CellState, JobState
from bt_orchestrator.script.orders.desk import AskedOrder, ChangedJob

REST = '-rest'
"""Behind the id of a job in that of its rest."""


def rest_of(state: CellState, job: str, order: str) -> ChangedJob:
    """Return the order for the rest of a job, in its present state.

    :param order: id of the rest; empty: one that is free
    :raises NotRead: the job has no rest that can be made, or the id cannot be one
    """
    try:
        live = allowed(state, job_control.REQUEUE, job)
    except CommandRefused as why:
        raise NotRead(str(why)) from None
    name = order or _free_id(state, live)
    fault = order_id_fault(name)
    if fault is not None:
        raise NotRead(f'{name!r} cannot be the id of the rest: {fault}; give another one')
    wish, had = AskedOrder(recipe=live.job.recipe), live.job
    return ChangedJob(name, live.digest, live.cycles_left, had.params, wish, had.terms, had.recipe)


def _free_id(state: CellState, job: JobState) -> str:
    """Return an id that no order had; that of the rest of a rest counts on."""
    base, _, _ = job.job.id.rpartition(REST) if job.rest_of else ('', '', '')
    first = f'{base or job.job.id}{REST}'
    names = chain([first], (f'{first}-{number}' for number in count(2)))
    return next(name for name in names if name not in state.order_ids)
