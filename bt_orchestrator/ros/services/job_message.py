"""Jobs as messages (bt_orchestrator_interfaces/msg/JobStatus)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from bt_orchestrator_interfaces.msg import JobStatus, PassedTask

from bt_orchestrator.model.codec import json_of
from bt_orchestrator.model.events import TaskKey
from bt_orchestrator.model.jobs.isa95 import job_word
from bt_orchestrator.model.limits import QUEUE_PAGE, fitting
from bt_orchestrator.model.state import CellState, End, JobState, Phase, TaskState
from bt_orchestrator.ros.stamps import to_moment

UNKNOWN_S = -1.0

DETAILS_TOLD_BYTES = 1_000_000
"""Most details of jobs in one answer; where they are longer it has fewer jobs."""


def job_messages(
    state: CellState, jobs: Iterable[JobState], ends: Mapping[str, float]
) -> list[JobStatus]:
    """Build the messages about some jobs, live or ended.

    :param ends: in how many seconds jobs are expected to end
    """
    return [
        _message(state, job, state.jobs.place(job.job.id), ends.get(job.job.id, UNKNOWN_S))
        for job in jobs
    ]


def list_queue(state: CellState, request: Any, response: Any) -> None:
    """Fill a response with jobs of the queue (bt_orchestrator_interfaces/srv/QueueList)."""
    place = state.jobs.place(request.after)
    if request.after and not place:
        response.message = f'{request.after} is not in the queue'
        return
    most = min(request.most or QUEUE_PAGE, QUEUE_PAGE)
    response.accepted, response.queued = True, state.jobs.waiting
    told = [(job, _details(job)) for job in state.jobs.queue(place + 1, most)]
    told = list(fitting(told, DETAILS_TOLD_BYTES, lambda one: len(one[1])))
    response.jobs = job_messages(state, [job for job, _ in told], {})
    response.details = [details for _, details in told]


def _details(job: JobState) -> str:
    details = job.job.terms.details
    return json_of(details) if details else ''


def _message(state: CellState, job: JobState, position: int, end_s: float) -> JobStatus:
    progress, word, live = job.progress, job_word(state, job), job.ended_at is None
    terms = job.job.terms
    return JobStatus(
        id=job.job.id,
        script=job.job.script.name,
        digest=job.digest,
        state=word.state,
        substate=word.substate,
        position=position,
        ending=job.ending if live else '',
        expected_end_s=end_s if live else UNKNOWN_S,  # a forecast may outlive its job
        quantity=job.job.quantity,
        priority=terms.priority,
        start=to_moment(terms.start),
        due=to_moment(terms.due),
        started=progress.started,
        placed=progress.placed,
        processed=progress.processed,
        packed=progress.packed,
        rejected=progress.rejected,
        nonconforming=progress.nonconforming,
        missing=progress.missing,
        initialization=_to_prepare(state, job) if live else [],
        passed=_prepared(state, job) if live and job.started else [],
    )


def passed_task(task: str, progress: TaskState, *, is_nonconforming: bool = False) -> PassedTask:
    """Build the message about a task in phase DONE.

    :param is_nonconforming: it made its item so; tells what a state of an older program does not
    """
    end = progress.end or (End.CONTINUED if is_nonconforming else End.DONE)
    return PassedTask(id=task, end=end.value, reason=_reason(progress))


def _reason(progress: TaskState) -> str:
    if progress.reason is None:
        return progress.message
    message = f' ({progress.message})' if progress.message else ''
    return f'{progress.reason.value}{message}'


def _to_prepare(state: CellState, job: JobState) -> list[str]:
    """Return the initialization tasks that have not succeeded yet."""
    if not job.started:
        return [task.id for task in job.job.script.initialization]
    return [
        task.id
        for task in job.job.script.initialization
        if state.phase(TaskKey(job.job.id, None, None, task.id)) is not Phase.DONE
    ]


def _prepared(state: CellState, job: JobState) -> list[PassedTask]:
    """Return the initialization tasks that have ended."""
    tasks = job.job.script.initialization
    ended = [
        (task.id, state.tasks.get(TaskKey(job.job.id, None, None, task.id))) for task in tasks
    ]
    return [passed_task(id_, one) for id_, one in ended if one and one.phase is Phase.DONE]
