"""An order that was proposed for the queue: which queue it is for, and whether it fits (6.7)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from bt_orchestrator.model.codec import digest_of, to_plain
from bt_orchestrator.model.limits import QUEUE_SHOWN, listed
from bt_orchestrator.model.state.job_state import JobState
from bt_orchestrator.model.state.live_jobs import LiveJobs
from bt_orchestrator.model.words import sentence


def queue_digest(jobs: LiveJobs) -> str:
    """Return a digest of the first jobs of the queue, with what can be changed of them.

    What passes by itself is no part of it, such as the wait for a start.
    """
    return digest_of([_facts(job) for job in jobs.queue(most=QUEUE_SHOWN)])


def _facts(job_state: JobState) -> list[Any]:
    job = job_state.job
    order = [job.id, job_state.digest, job.quantity, to_plain(job.params), to_plain(job.terms)]
    return [*order, job_state.held, job_state.ranked, job_state.aborting]


def refused_order(jobs: LiveJobs, wanted: Sequence[str], digest: str) -> str | None:
    """Say why the queue is not put into an order; None: it can be.

    :param digest: of the queue that the order was proposed for
    """
    queue = jobs.queue(most=QUEUE_SHOWN)
    names = [job.job.id for job in queue]
    if digest != queue_digest(jobs):
        return _change(names, wanted)
    if sorted(wanted) != sorted(names):
        return sentence('queue_names', jobs=listed(names, 'none'))
    for place, (job, name) in enumerate(zip(queue, wanted, strict=True), start=1):
        if not job.ranked and job.job.id != name:
            return sentence('place_chosen', job=job.job.id, place=place)
    return sentence('queue_same') if names == list(wanted) else None


def _change(names: Sequence[str], wanted: Sequence[str]) -> str:
    gone = [name for name in wanted if name not in names]
    new = [name for name in names if name not in wanted]
    if gone and new:
        return sentence('queue_both', jobs=listed(gone, ''), others=listed(new, ''))
    if gone or new:
        kind = 'queue_left' if gone else 'queue_came'
        return sentence(kind, jobs=listed(gone or new, ''))
    return sentence('queue_other')
