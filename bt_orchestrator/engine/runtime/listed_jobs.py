"""The jobs that a cell lists: the last that ended, those on the line, then the queue."""

from __future__ import annotations

from bt_orchestrator.base.errors import CommandRefused
from bt_orchestrator.engine.runtime.overview import Overview
from bt_orchestrator.model.limits import QUEUE_PAGE, fitting, listed, rough_size
from bt_orchestrator.model.state import CellState, JobState
from bt_orchestrator.model.status import ListedJob
from bt_orchestrator.model.words import sentence

PAGE_BYTES = 1_000_000
"""Most parameters and details in one answer; where they are longer it has fewer jobs."""


def find(state: CellState, name: str) -> JobState:
    """Return a listed job.

    :raises CommandRefused: there is none of this name (any more)
    """
    job = state.jobs.get(name) or state.ended.get(name)
    if job is not None:
        return job
    if name in state.order_ids:
        raise CommandRefused(sentence('not_listed', job=name))
    raise CommandRefused(sentence('no_job', job=name, jobs=listed(state.jobs, 'none')))


def page(state: CellState, overview: Overview, after: str = '', most: int = 0) -> list[ListedJob]:
    """Return jobs behind one, in an order in which a job only moves to the front as it goes on.

    So nothing is passed over between two pages, unless an operator moves a job.

    :param after: empty: from the first
    :param most: maximum number; 0: as many as fit
    :raises CommandRefused: that job is not listed (any more)
    """
    jobs = _behind(state, after, min(most or QUEUE_PAGE, QUEUE_PAGE))
    entries = (told_of(job, overview) for job in jobs)
    return list(
        fitting(entries, PAGE_BYTES, lambda entry: rough_size((entry.params, entry.details)))
    )


def told_of(job: JobState, overview: Overview) -> ListedJob:
    """Return the answer to a question about a job."""
    order = job.job
    details = order.terms.details
    return ListedJob(overview.job(job), order.params, details, job.end_reason, order.recipe)


def _behind(state: CellState, after: str, most: int) -> list[JobState]:
    place = state.jobs.place(after)
    if place:
        return state.jobs.queue(place + 1, most)
    before = [*state.ended.values(), *state.jobs.line.values()]
    if after:
        before = before[before.index(find(state, after)) + 1 :]
    return [*before, *state.jobs.queue(1, most)][:most]
