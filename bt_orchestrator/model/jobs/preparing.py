"""When a task of an initialization may start, or be skipped (semantics 5)."""

from __future__ import annotations

from bt_orchestrator.model.events import TaskKey
from bt_orchestrator.model.jobs.setups import stays
from bt_orchestrator.model.line import (
    is_done_with,
    may_not_begin,
    stopped_because,
    waits_for_earlier_jobs,
    waits_for_tasks,
)
from bt_orchestrator.model.script import Task
from bt_orchestrator.model.state import CellState, JobState, Phase, same_task
from bt_orchestrator.model.wait import Wait, WaitKind


def may_not_prepare(state: CellState, job: str) -> Wait | None:
    """Say what keeps a job from all of its initialization (semantics 6.6, 7.1)."""
    return stopped_because(state) or may_not_begin(state, state.jobs[job])


def waits_for_its_turn(state: CellState, job: str, task: Task) -> Wait | None:
    """Say what has to be done before an initialization task: others, and jobs (semantics 5)."""
    preparation = state.preparations[state.jobs[job].digest]
    for upstream in preparation.upstream[task.id]:
        if not _is_prepared(state, job, upstream):
            what = f'waiting for initialization {upstream}'
            return Wait(what, WaitKind.INITIALIZATION, upstream, task=upstream)
    sections = preparation.sections[task.id]
    return waits_for_earlier_jobs(state, job, sections) or _waits_in_order(state, job, task)


def _waits_in_order(state: CellState, job: str, task: Task) -> Wait | None:
    """Say what an earlier job is still to do with the same component (semantics 5.2)."""
    for earlier in state.jobs.before(job):
        there = [t for t in earlier.job.script.initialization if t.component == task.component]
        wait = waits_for_tasks(state, earlier, there)
        if wait is not None:
            return wait
    return None


def remains_done(state: CellState, job: str, task: Task) -> bool:
    """Tell whether what is done remains so until a job begins (semantics 5.1).

    Only then may it be skipped before its turn; so may a change of a setup (5.3). A job begins
    when its source has finished the earlier ones; until then another may be put in front of it.
    """
    live = state.jobs[job]
    source = state.sections[live.job.script.source]
    before = list(state.jobs.before(job))
    if not all(is_done_with(state, source, earlier) for earlier in before):
        return False
    if task.is_implied:
        return stays(state, live, before, task)
    return not _prepares(state, live, task, besides=task.id) and not any(
        _prepares(state, one, task) or _does(state, one, task) for one in before
    )


def _prepares(state: CellState, job: JobState, task: Task, *, besides: str = '') -> bool:
    """Tell whether initialization of a job is still to do the same task.

    :param besides: id of a task of this job that does not count. Jobs of one script share its
        `Task` objects, so identity would leave out the tasks of earlier jobs too.
    """
    name = job.job.id
    return any(
        one.id != besides and same_task(one) == same_task(task)
        for one in job.job.script.initialization
        if not _is_prepared(state, name, one.id)
    )


def _does(state: CellState, job: JobState, task: Task) -> bool:
    """Tell whether a section may still do the same task for a job."""
    return any(
        same_task(one) == same_task(task)
        for number, tasks in job.job.script.sections.items()
        if not is_done_with(state, state.sections[number], job)
        for one in tasks.tasks
    )


def _is_prepared(state: CellState, job: str, task: str) -> bool:
    return state.phase(TaskKey(job, None, None, task)) is Phase.DONE
