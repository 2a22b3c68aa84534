"""The status of a job: place, counts, tasks in flight, and why its end cannot be expected."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from itertools import takewhile

from bt_orchestrator.engine.runtime.goal_ends import feedback_text
from bt_orchestrator.engine.runtime.observed_durations import ObservedDurations
from bt_orchestrator.engine.runtime.stands import Engine, Goals, obstacles
from bt_orchestrator.model.events import INDEX_KEY, TaskKey
from bt_orchestrator.model.hold_words import hold_wait_words
from bt_orchestrator.model.jobs.counting import APPROVED
from bt_orchestrator.model.jobs.isa95 import job_word
from bt_orchestrator.model.jobs.needs import awaited_by, needs_words
from bt_orchestrator.model.limits import FEEDBACK_BYTES
from bt_orchestrator.model.state import CellState, JobState, PassedTask, Phase, TaskState
from bt_orchestrator.model.status import JobStatus, TaskStatus
from bt_orchestrator.model.task_spans import passed_task
from bt_orchestrator.model.wait import StandCause, Stands
from bt_orchestrator.model.words import joined, sentence


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
        first_piece=job.piece or job.approved,
        first_piece_state=job.piece_left if job.piece else APPROVED if job.approved else '',
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
    return tuple(
        passed_task(id_, task) for id_, task in ended if task and task.phase is Phase.DONE
    )


# Why the end of a job cannot be expected: somebody has to do something first.

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
            lacks = awaited_by(self._state, job)
            if job.paused and job.cycles_left:
                kind = 'job_awaits_piece' if job.piece else 'job_paused'
                return sentence(kind, job=name, item=job.piece)
            return needs_words(name, lacks) if lacks else ''
        return joined(*(words for cause, words in obstacles(job) if cause not in _KNOWN))

    def _of_those_before(self, job: JobState) -> str:
        """Say what keeps a job on the line before this one."""
        before = takewhile(lambda other: other is not job, self._state.jobs.line.values())
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


# The tasks with a goal in flight, as a status shows them.


class TasksInFlight:
    """All of them at one moment, by place."""

    def __init__(self, engine: Engine, durations: ObservedDurations) -> None:
        self._engine = engine
        self._durations = durations

    def of_belt(self) -> tuple[TaskStatus, ...]:
        """Return the belt's own move."""
        return self._of([INDEX_KEY])

    def of_section(self, number: int) -> tuple[TaskStatus, ...]:
        """Return the tasks of a section."""
        return self._of(self._by_section.get(number, ()))

    def of_initialization(self, job: JobState) -> tuple[TaskStatus, ...]:
        """Return the initialization tasks of a job."""
        tasks = job.job.script.initialization if job.started else ()
        return self._of(TaskKey(job.job.id, None, None, task.id) for task in tasks)

    @cached_property
    def _by_section(self) -> Mapping[int | None, Sequence[TaskKey]]:
        keys: dict[int | None, list[TaskKey]] = defaultdict(list)
        for key in self._engine.state.running:
            keys[key.section].append(key)
        return keys

    def _of(self, keys: Iterable[TaskKey]) -> tuple[TaskStatus, ...]:
        running = self._engine.state.running
        return tuple(self._status(key, running[key]) for key in keys if key in running)

    def _status(self, key: TaskKey, progress: TaskState) -> TaskStatus:
        state = self._engine.state
        task, conveyor = state.task(key), state.cell.conveyor
        name = task.name if task else conveyor.task
        component = task.component if task else conveyor.component.name
        return TaskStatus(
            id=key.task,
            name=name,
            component=component,
            action=task.action if task else conveyor.component.action,
            attempt=progress.attempt,
            goal=progress.goal or '',
            started=progress.started,
            expected_s=self._expected_s(component, name),
            feedback=feedback_of(self._engine.flights, progress.goal),
            round=state.round(key),
        )

    def _expected_s(self, component: str, name: str) -> float | None:
        observed_s = self._durations.usual_s(component, name)
        if observed_s is not None:
            return observed_s
        known = self._engine.state.cell.components.get(component)
        return None if known is None else known.duration_s(name)


def feedback_of(flights: Goals, goal: str | None) -> str:
    """Return the last feedback of a goal as a JSON object, shortened if it is long."""
    flight = flights.goal(goal) if goal else None
    return feedback_text(flight.feedback, FEEDBACK_BYTES) if flight else ''
