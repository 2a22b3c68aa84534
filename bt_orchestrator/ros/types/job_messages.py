"""Jobs as messages (JobStatus, ListedJob), and back."""

from __future__ import annotations

import json
from typing import Any

from bt_orchestrator_interfaces import msg
from builtin_interfaces.msg import Time

from bt_orchestrator.model.codec import json_of
from bt_orchestrator.model.jobs.counting import good_of
from bt_orchestrator.model.jobs.isa95 import JobWord
from bt_orchestrator.model.jobs.made_anew import MadeAnew
from bt_orchestrator.model.status import JobStatus, ListedJob
from bt_orchestrator.ros.stamps import from_moment, from_time, to_moment, to_time
from bt_orchestrator.ros.types.choice_messages import choice_fields, choice_from
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
        recipe=job.recipe,
        recipe_version=job.recipe_version or 0,
        by_recipe=job.by_recipe,
        rest_of=job.rest_of,
        **_anew_fields(job.anew),
        state=job.state.state,
        substate=job.state.substate,
        position=job.position,
        ending=job.ending,
        expected_end_s=from_seconds(job.expected_end_s),
        quantity=job.quantity,
        priority=job.priority,
        start=to_moment(job.start),
        due=to_moment(job.due),
        awaits_start=job.awaits_start,
        awaits_release=job.awaits_release,
        held=job.held,
        unavailable=job.unavailable,
        queued_at=to_time(job.queued_at),
        started_at=to_moment(job.started_at),
        ended_at=to_moment(job.ended_at),
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
        recipe=message.recipe,
        recipe_version=message.recipe_version or None,
        by_recipe=message.by_recipe,
        rest_of=message.rest_of,
        anew=_anew(message),
        state=JobWord(f'{message.state}{substate}'),
        position=message.position,
        ending=message.ending,
        expected_end_s=to_seconds(message.expected_end_s),
        quantity=message.quantity,
        priority=message.priority,
        start=from_moment(message.start),
        due=from_moment(message.due),
        awaits_start=message.awaits_start,
        awaits_release=message.awaits_release,
        held=message.held,
        unavailable=tuple(message.unavailable),
        queued_at=from_time(message.queued_at),
        started_at=from_moment(message.started_at),
        ended_at=from_moment(message.ended_at),
        started=message.started,
        placed=message.placed,
        processed=message.processed,
        packed=message.packed,
        rejected=message.rejected,
        nonconforming=message.nonconforming,
        missing=message.missing,
        good=good_of(message.packed, message.nonconforming),
        by_hand=_by_hand(message),
        initialization=tuple(message.initialization),
        running=tuple(map(task_status, message.running)),
        passed=tuple(map(passed_task, message.passed)),
    )


def _by_hand(message: msg.JobStatus) -> int:
    """Derive how many items were taken off the belt by hand; of a job at work 1 may be lacking."""
    if message.ended_at != Time():
        return int(message.placed - message.packed - message.rejected)
    return max(int(message.missing + message.placed - message.started), 0)


def _anew_fields(anew: MadeAnew | None) -> dict[str, Any]:
    if anew is None:
        return {}
    return {
        'made_anew': True,
        'made_without': anew.without,
        'made_with': anew.back,
        'made_per_item_s': anew.per_item_s,
        'made_before_s': anew.before_s,
    }


def _anew(message: msg.JobStatus) -> MadeAnew | None:
    if not message.made_anew:
        return None
    return MadeAnew(
        tuple(message.made_without),
        tuple(message.made_with),
        message.made_per_item_s,
        message.made_before_s,
    )


def listed_message(job: ListedJob) -> msg.ListedJob:
    """Return the message about a job that was asked for."""
    return msg.ListedJob(
        job=job_message(job.status),
        params=json_of(job.params),
        details=json_of(job.details) if job.details else '',
        reason=job.reason,
        **choice_fields(job.choice),
    )


def listed_job(message: msg.ListedJob) -> ListedJob:
    """Return what a message says of a job that was asked for."""
    return ListedJob(
        job_status(message.job),
        json.loads(message.params),
        json.loads(message.details or '{}'),
        message.reason,
        choice_from(message),
    )
