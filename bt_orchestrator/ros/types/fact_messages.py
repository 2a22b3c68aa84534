"""Facts inside other messages (Words, Stands, JobFacts, FinishedCycle), and back."""

from __future__ import annotations

from bt_orchestrator_interfaces import msg
from diagnostic_msgs.msg import KeyValue

from bt_orchestrator.model.frozen import changed
from bt_orchestrator.model.stands import StandCause, Stands
from bt_orchestrator.model.status import FinishedCycle, JobStatus
from bt_orchestrator.model.words import Words
from bt_orchestrator.ros.stamps import from_time, to_time
from bt_orchestrator.ros.types.task_messages import passed_message, passed_task


def words_message(words: Words | None) -> msg.Words:
    """Return the message about a sentence; of none an empty one."""
    if words is None:
        return msg.Words()
    values = [KeyValue(key=key, value=value) for key, value in words.values.items()]
    return msg.Words(kind=words.kind, values=values)


def words_of(message: msg.Words) -> Words | None:
    """Return the sentence of a message."""
    if not message.kind:
        return None
    return Words(message.kind, {one.key: one.value for one in message.values})


def stands_message(stands: Stands | None) -> msg.Stands:
    """Return the message about a standstill; of none an empty one."""
    if stands is None:
        return msg.Stands()
    return msg.Stands(
        since=to_time(stands.since),
        cause=stands.cause.value,
        name=stands.name,
        sections=stands.sections,
        components=stands.components,
        reason=stands.reason,
    )


def stands_of(message: msg.Stands) -> Stands | None:
    """Return the standstill of a message."""
    if not message.cause:
        return None
    return Stands(
        since=from_time(message.since),
        cause=StandCause(message.cause),
        reason=message.reason,
        name=message.name,
        sections=tuple(map(int, message.sections)),
        components=tuple(message.components),
    )


def finished_message(finished: FinishedCycle | None) -> msg.FinishedCycle:
    """Return the message about a completed cycle; of none an empty one."""
    if finished is None:
        return msg.FinishedCycle()
    return msg.FinishedCycle(
        job=finished.job,
        item=finished.item,
        passed=[passed_message(task) for task in finished.passed],
        failed=finished.failed,
    )


def finished_of(message: msg.FinishedCycle) -> FinishedCycle | None:
    """Return the completed cycle of a message."""
    if not message.job:
        return None
    return FinishedCycle(
        job=message.job,
        item=message.item,
        passed=tuple(map(passed_task, message.passed)),
        failed=tuple(message.failed),
    )


def job_facts_message(job: JobStatus) -> msg.JobFacts:
    """Return what the message about a job cannot carry."""
    return msg.JobFacts(
        job=job.id, good=job.good, by_hand=job.by_hand, end_unknown=job.end_unknown
    )


def with_facts(job: JobStatus, facts: msg.JobFacts) -> JobStatus:
    """Return a job with what its own message cannot carry."""
    return changed(job, good=facts.good, by_hand=facts.by_hand, end_unknown=facts.end_unknown)
