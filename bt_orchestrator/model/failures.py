"""What becomes of a failed attempt: retry, or the task's policy (semantics 2.6, 2.7)."""

from __future__ import annotations

from collections.abc import Iterator

from bt_orchestrator.model import effects
from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import OnFailure
from bt_orchestrator.model.goal import Reason
from bt_orchestrator.model.script import INDEX, Task
from bt_orchestrator.model.state import CellState, TaskState

SHUTDOWN = 'shutdown'
"""Cancel cause after which a task is held whatever its policy (semantics 2.6)."""

ABORT = 'abort'
"""Cancel cause after which a task is in doubt: the cell was aborted (semantics 7.2)."""

ABORT_JOB = 'abort_job'
"""Cancel cause after which a task counts as failed and continued (semantics 2.6)."""


def may_retry(state: CellState, key: e.TaskKey, task: Task) -> bool:
    """Tell whether the task's own retries allow another attempt."""
    failed = state.tasks[key]
    if failed.attempt > task.retries or failed.reason is Reason.MISSING_RESULT:
        return False
    return _is_settled(failed, task) and not _is_own_cancel(failed)


def will_hold(state: CellState, key: e.TaskKey, task: Task) -> bool:
    """Tell whether an operator will be asked about a failed attempt."""
    if may_retry(state, key, task):
        return False
    return key == e.INDEX_KEY or _policy(state, key, task) is OnFailure.HOLD


def decide(state: CellState, key: e.TaskKey, task: Task) -> Iterator[e.Event]:
    """Decide about a task whose last attempt failed."""
    policy = _policy(state, key, task)
    if policy is OnFailure.HOLD:
        yield raise_hold(state, key, task)
    elif key == e.INDEX_KEY:
        yield from abort_all_on_the_belt(state, 'the index move failed')
        yield raise_hold(state, key, task)
    else:
        yield from pass_over(state, key, policy, f'{task.id} failed: {_failure(state, key)}')


def pass_over(
    state: CellState, key: e.TaskKey, policy: OnFailure, reason: str
) -> Iterator[e.Event]:
    """Let the cycle go on after a failure, as a policy or an operator says."""
    assert key.job is not None
    if policy is OnFailure.REJECT and key.item and not state.items[key.item].rejected:
        yield e.ItemRejected(job=key.job, item=key.item, reason=reason)
    if policy is OnFailure.ABORT_JOB:
        yield from effects.of_abort(state, state.jobs[key.job], reason)
    yield e.TaskContinued(**key._asdict(), policy=policy.value)
    yield from effects.of_passing(state, key)


def raise_hold(state: CellState, key: e.TaskKey, task: Task) -> e.HoldRaised:
    """Ask an operator about a task (semantics 7.1)."""
    failed = state.tasks[key]
    return e.HoldRaised(
        hold=state.next_hold,
        **key._asdict(),
        reason=failed.reason.value if failed.reason else 'failed',
        message=failed.message,
        answers=answers(key, task),
    )


def answers(key: e.TaskKey, task: Task) -> tuple[str, ...]:
    """Return what an operator may answer about a held task (semantics 3.5, 7.1)."""
    if task.id == INDEX:
        return ('retry', 'mark_done', 'abort_job')
    offered = ['retry', 'mark_done']
    if task.qty_change != -1:
        offered.append('skip')
    if key.item is not None:
        offered.append('reject')
    return (*offered, 'abort_job')


def _policy(state: CellState, key: e.TaskKey, task: Task) -> OnFailure:
    failed = state.tasks[key]
    if not _is_settled(failed, task) or failed.cancel_cause in (SHUTDOWN, ABORT):
        return OnFailure.HOLD
    if _is_own_cancel(failed):
        return OnFailure.ABORT_JOB
    return task.on_failure


def _is_settled(failed: TaskState, task: Task) -> bool:
    """Tell whether it is certain that nothing of the attempt goes on (semantics 2.6)."""
    if failed.reason is Reason.SERVER_LOST:
        return task.repeatable
    return failed.reason is not Reason.IN_DOUBT


def _is_own_cancel(failed: TaskState) -> bool:
    """Tell whether the attempt ended because the orchestrator wished so (semantics 2.6).

    What fails while an aborted job drains is a failure like any other.
    """
    return failed.cancel_cause in (SHUTDOWN, ABORT, ABORT_JOB)


def _failure(state: CellState, key: e.TaskKey) -> str:
    failed = state.tasks[key]
    word = failed.reason.value if failed.reason else 'failed'
    return f'{word}, {failed.message}' if failed.message else word


def abort_all_on_the_belt(state: CellState, reason: str) -> Iterator[e.Event]:
    """Abort every job with something on the belt (semantics 3.5)."""
    jobs = {state.items[s.slot].job for s in state.sections.values() if s.slot is not None}
    for job in [job for job in state.jobs.values() if job.job.id in jobs]:
        yield from effects.of_abort(state, job, reason)
