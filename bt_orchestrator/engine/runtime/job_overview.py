"""The status of a job: its place, its counts, its initialization."""

from __future__ import annotations

from collections.abc import Mapping

from bt_orchestrator.engine.runtime.ends_unknown import Unknown
from bt_orchestrator.engine.runtime.tasks_in_flight import TasksInFlight
from bt_orchestrator.model.events import TaskKey
from bt_orchestrator.model.jobs.isa95 import job_word
from bt_orchestrator.model.jobs.needs import awaited_by
from bt_orchestrator.model.passed import passed_task
from bt_orchestrator.model.state import CellState, JobState, PassedTask, Phase
from bt_orchestrator.model.status import JobStatus


def job_status(
    state: CellState,
    job: JobState,
    in_flight: TasksInFlight,
    ends_s: Mapping[str, float],
    unknown: Unknown,
) -> JobStatus:
    """Return the status of a job, live or ended.

    :param ends_s: in how many seconds jobs are expected to end
    :param unknown: says of which jobs nobody can know it
    """
    why_unknown = unknown.why(job)
    progress, terms = job.progress, job.job.terms
    id_, is_live = job.job.id, job.ended_at is None
    return JobStatus(
        id=id_,
        script=job.job.script.name,
        digest=job.digest,
        recipe=job.recipe,
        recipe_version=job.recipe_version,
        by_recipe=job.job.recipe is not None,
        rest_of=job.rest_of,
        anew=job.anew,
        state=job_word(state, job),
        position=state.jobs.place(id_),
        ending=job.ending if is_live else '',
        # A forecast may outlive its job.
        expected_end_s=ends_s.get(id_) if is_live and not why_unknown else None,
        end_unknown=why_unknown,
        quantity=job.job.quantity,
        priority=terms.priority,
        start=terms.start,
        due=terms.due,
        awaits_start=job.awaits_start,
        awaits_release=job.awaits_release,
        held=job.held,
        unavailable=awaited_by(state, job),
        queued_at=job.queued_at,
        started_at=job.started_at,
        ended_at=job.ended_at,
        started=progress.started,
        placed=progress.placed,
        processed=progress.processed,
        packed=progress.packed,
        rejected=progress.rejected,
        nonconforming=progress.nonconforming,
        missing=progress.missing,
        good=progress.good,
        by_hand=progress.by_hand,
        initialization=_to_prepare(state, job) if is_live else (),
        running=in_flight.of_initialization(job) if is_live else (),
        passed=_prepared(state, job) if is_live and job.started else (),
    )


def _to_prepare(state: CellState, job: JobState) -> tuple[str, ...]:
    """Return the initialization tasks that have not succeeded yet."""
    tasks = job.job.script.initialization
    if not job.started:
        return tuple(task.id for task in tasks)
    id_ = job.job.id
    return tuple(
        task.id
        for task in tasks
        if state.phase(TaskKey(id_, None, None, task.id)) is not Phase.DONE
    )


def _prepared(state: CellState, job: JobState) -> tuple[PassedTask, ...]:
    """Return the initialization tasks that have ended."""
    tasks = job.job.script.initialization
    ended = [
        (task.id, state.tasks.get(TaskKey(job.job.id, None, None, task.id))) for task in tasks
    ]
    return tuple(passed_task(id_, one) for id_, one in ended if one and one.phase is Phase.DONE)
