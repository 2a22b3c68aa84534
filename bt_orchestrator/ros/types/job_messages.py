"""Jobs as messages (JobStatus), and back."""

from __future__ import annotations

from bt_orchestrator_interfaces import msg

from bt_orchestrator.model.jobs.isa95 import JobWord
from bt_orchestrator.model.status import JobStatus
from bt_orchestrator.ros.stamps import from_moment, to_moment
from bt_orchestrator.ros.types.task_messages import (
    from_seconds,
    passed_message,
    passed_task,
    task_message,
    task_status,
    to_seconds,
)


def job_message(job: JobStatus) -> msg.JobStatus:
    """Return the message about a job."""
    return msg.JobStatus(
        id=job.id,
        script=job.script,
        digest=job.digest,
        state=job.state.state,
        substate=job.state.substate,
        position=job.position,
        ending=job.ending,
        expected_end_s=from_seconds(job.expected_end_s),
        quantity=job.quantity,
        priority=job.priority,
        start=to_moment(job.start),
        due=to_moment(job.due),
        started=job.started,
        placed=job.placed,
        processed=job.processed,
        packed=job.packed,
        rejected=job.rejected,
        nonconforming=job.nonconforming,
        missing=job.missing,
        initialization=job.initialization,
        running=[task_message(task) for task in job.running],
        passed=[passed_message(task) for task in job.passed],
    )


def job_status(message: msg.JobStatus) -> JobStatus:
    """Return what a message says of a job."""
    substate = f'/{message.substate}' if message.substate else ''
    return JobStatus(
        id=message.id,
        script=message.script,
        digest=message.digest,
        state=JobWord(f'{message.state}{substate}'),
        position=message.position,
        ending=message.ending,
        expected_end_s=to_seconds(message.expected_end_s),
        quantity=message.quantity,
        priority=message.priority,
        start=from_moment(message.start),
        due=from_moment(message.due),
        started=message.started,
        placed=message.placed,
        processed=message.processed,
        packed=message.packed,
        rejected=message.rejected,
        nonconforming=message.nonconforming,
        missing=message.missing,
        initialization=tuple(message.initialization),
        running=tuple(map(task_status, message.running)),
        passed=tuple(map(passed_task, message.passed)),
    )
