"""Decisions about a failed attempt: retry, or the task's policy (semantics 2.6, 2.7)."""

from __future__ import annotations

from collections.abc import Iterator

from bt_orchestrator.model import effects
from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import OnFailure
from bt_orchestrator.model.frozen import changed
from bt_orchestrator.model.goal import Reason
from bt_orchestrator.model.judging.rejects import hold_of_run
from bt_orchestrator.model.script import Repeat, Task, index_task
from bt_orchestrator.model.state import CellState, JobState, TaskState
from bt_orchestrator.model.words import OR, OVERRUN, SLOT_OCCUPIED, Words, sentence

SHUTDOWN = 'shutdown'
"""Cancel cause after which a task is held whatever its policy (semantics 2.6)."""

ABORT = 'abort'
"""Cancel cause after which a task is in doubt: the cell was aborted (semantics 7.2)."""

ABORT_JOB = 'abort_job'
"""Cancel cause after which a task counts as failed and continued, unless its slot is in doubt
(semantics 2.6, 4.3)."""

RETRY, AGAIN, MARK_DONE, SKIP, REJECT = 'retry', 'again', 'mark_done', 'skip', 'reject'
CHANGE = 'change'
"""Answers to holds about tasks; the seventh is ABORT_JOB (semantics 7.1)."""

SUCCEEDED = 'succeeded'
"""The status topic says so of a goal without a result."""

_NEVER_BEGUN = (
    Reason.GOAL_REJECTED,
    Reason.SERVER_UNAVAILABLE,
    Reason.MISSING_RESULT,
    Reason.SETUP_MISSING,
)
"""Ends of attempts that never reached a robot."""

_NEVER_RETRIED = (Reason.MISSING_RESULT, Reason.DUPLICATE_SERIAL, Reason.SETUP_MISSING)


def may_retry(state: CellState, key: e.TaskKey, task: Task) -> bool:
    """Tell whether the task's own retries allow another attempt."""
    failed = state.tasks[key]
    if failed.attempt > task.retries or failed.reason in _NEVER_RETRIED:
        return False
    if failed.reason is Reason.RESULT_REFUSED and _repeat(state, key) is not None:
        return False
    return _is_settled(failed, task) and not _is_own_cancel(failed)


def may_repeat(state: CellState, key: e.TaskKey, task: Task) -> bool:
    """Tell whether a refused result begins another round of the task's repeat (semantics 3.9)."""
    failed, repeat = state.tasks[key], _repeat(state, key)
    if repeat is None or failed.reason is not Reason.RESULT_REFUSED:
        return False
    if failed.cancel_cause is not None or effects.why_skipped(state, key, task) is not None:
        return False
    return state.round(key) < repeat.times and _why_no_round(state, key) is None


def _why_no_round(state: CellState, key: e.TaskKey) -> str | None:
    """Say why no round begins for an item, neither by a verdict nor by `again` (semantics 3.9)."""
    assert key.job is not None
    assert key.item is not None
    if state.jobs[key.job].aborting:
        return sentence('aborting')
    return sentence('good_items') if state.items[key.item].rejected else None


def begin_round(state: CellState, key: e.TaskKey) -> e.RoundBegun:
    """Do the tasks of a repeat once more."""
    repeat = _repeat(state, key)
    assert repeat is not None
    assert key.job is not None
    assert key.section is not None
    assert key.item is not None
    return e.RoundBegun(
        job=key.job,
        section=key.section,
        item=key.item,
        repeat=repeat.name,
        n=state.round(key) + 1,
        tasks=repeat.tasks,
    )


def _repeat(state: CellState, key: e.TaskKey) -> Repeat | None:
    return None if key.job is None else state.script(key.job).repeat_of.get(key.task)


def will_hold(state: CellState, key: e.TaskKey, task: Task) -> bool:
    """Tell whether an operator will be asked about a failed attempt."""
    if key == e.MANUAL_KEY:
        return not _is_settled(state.tasks[key], task)
    if may_retry(state, key, task) or may_repeat(state, key, task):
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
    """Continue the cycle after a failure, as decided by the policy or an operator."""
    assert key.job is not None
    if policy is OnFailure.REJECT and key.item and not state.items[key.item].rejected:
        yield e.ItemRejected(job=key.job, item=key.item, reason=reason)
    if policy is OnFailure.ABORT_JOB:
        yield from effects.of_abort(state, state.jobs[key.job], reason)
    yield e.TaskContinued(**key._asdict(), policy=policy.value)
    yield from effects.of_passing(state, key)
    if policy is OnFailure.REJECT:
        yield from hold_of_run(state, key)


def raise_hold(state: CellState, key: e.TaskKey, task: Task) -> e.HoldRaised:
    """Ask an operator about a task (semantics 7.1)."""
    failed = state.tasks[key]
    raised = e.HoldRaised(
        hold=state.next_hold,
        **key._asdict(),
        name=task.name,
        component=task.component,
        action=task.action,
        attempt=failed.attempt,
        attempts=task.retries + 1,
        reason=failed.reason.value if failed.reason else 'failed',
        answers=answers(state, key, task),
        round=state.round(key),
        controller_said=failed.controller_said,
        last_feedback=failed.last_feedback,
        topic_says=failed.topic_says,
    )
    return worded(state, raised)


def worded(state: CellState, hold: e.HoldRaised) -> e.HoldRaised:
    """Return a hold with its message, as its facts say it."""
    words = message_words(state, hold)
    return changed(hold, message='; '.join(word.text() for word in words))


def message_words(state: CellState, hold: e.HoldRaised) -> tuple[Words, ...]:
    """Return the sentences of a hold's message; none: they are known in words only."""
    facts = {'item': str(hold.item), 'section': str(hold.section)}
    if hold.reason == OVERRUN:
        return (Words(OVERRUN, facts),)
    if hold.reason == SLOT_OCCUPIED and hold.section is not None:
        return (Words(SLOT_OCCUPIED, {**facts, 'there': str(state.sections[hold.section].slot)}),)
    if hold.task is None:
        return ()
    key = e.TaskKey(hold.job, hold.section, hold.item, hold.task)
    failed, task = state.tasks.get(key), state.task(key) or index_task(state.cell)
    if failed is None:
        return ()
    quote = Words('said', {'words': failed.message}) if failed.message else None
    otherwise = OR.join(answer for answer in hold.answers if answer != MARK_DONE)
    moved = 'placed' if task.qty_change == 1 else 'taken_out'
    question = Words(moved, {**facts, 'answers': otherwise}) if _is_open(failed, task) else None
    return tuple(filter(None, (quote, question, _wanted(state, key))))


def answers(state: CellState, key: e.TaskKey, task: Task) -> tuple[str, ...]:
    """Return what an operator may answer about a held task now (semantics 3.5, 4.3, 7.1)."""
    choices = [answer for answer, obstacle in _obstacles(state, key, task) if obstacle is None]
    # The topic decides nothing, but what it says is the likelier truth (decision 0018).
    if state.tasks[key].topic_says == SUCCEEDED:
        choices.sort(key=lambda answer: answer != MARK_DONE)
    return tuple(choices)


def why_not_offered(state: CellState, key: e.TaskKey, task: Task) -> str:
    """Say why a held task offers no more answers; empty: it offers all that could make sense."""
    by_obstacle: dict[str, list[str]] = {}
    for answer, obstacle in _obstacles(state, key, task):
        if obstacle:
            by_obstacle.setdefault(obstacle, []).append(answer)
    return '; '.join(
        sentence('no_answers', answers=' or '.join(named), words=why)
        for why, named in by_obstacle.items()
    )


_NEVER = ''
"""An obstacle that needs no words: the answer makes no sense for such a task."""


def _obstacles(state: CellState, key: e.TaskKey, task: Task) -> Iterator[tuple[str, str | None]]:
    """Yield each answer with what speaks against it; None: it is offered."""
    if key == e.MANUAL_KEY:
        yield SKIP, None
        return
    if key.job is None:
        aborts = any(not job.aborting for job in _jobs_on_the_belt(state))
        yield from ((RETRY, None), (MARK_DONE, None))
        yield ABORT_JOB, None if aborts else sentence('none_to_abort')
        return
    failed = state.tasks[key]
    unknown = _what_is_unknown(key, task) if _is_open(failed, task) else None
    again = _why_not_again(state, key, task)
    if failed.reason is Reason.SETUP_MISSING:
        yield CHANGE, again or _why_no_change(state, key)
    else:
        # A missing result would be missing again.
        is_missing = failed.reason is Reason.MISSING_RESULT
        yield RETRY, again or (sentence('missing_again') if is_missing else None)
        no_round = _repeat(state, key) is None
        yield AGAIN, _NEVER if no_round else again or _why_no_round(state, key)
    yield MARK_DONE, None
    would_stay = task.qty_change == -1 and again is None
    yield SKIP, sentence('would_stay') if would_stay else None
    yield REJECT, unknown or _why_not_rejected(state, key)
    is_aborting = state.jobs[key.job].aborting
    yield ABORT_JOB, unknown or (sentence('aborting') if is_aborting else None)


def _why_not_again(state: CellState, key: e.TaskKey, task: Task) -> str | None:
    """Say why no further attempt makes sense (semantics 4.3, 7.1)."""
    failed = state.tasks[key]
    if _is_open(failed, task) and failed.cancel_cause == ABORT_JOB:
        return sentence('cancelled_with_job')
    skipped = effects.why_skipped(state, key, task)
    return None if skipped is None else sentence('would_be_skipped', why=skipped)


def _why_no_change(state: CellState, key: e.TaskKey) -> str | None:
    """Say why no change is made for a job: it would be skipped as its initialization (6.6)."""
    assert key.job is not None
    return sentence('aborting') if state.jobs[key.job].aborting else None


def _why_not_rejected(state: CellState, key: e.TaskKey) -> str | None:
    """Say why the item cannot be rejected: it must be there and good, in the turn (3.8)."""
    if key.job is None or key.item is None or key.section is None:
        return _NEVER
    item, tasks = state.items[key.item], state.script(key.job).sections[key.section]
    if item.rejected:
        return sentence('rejected')
    if not item.present or item.gone:
        return sentence('not_there')
    in_turn = (task.id for step in tasks.steps[: tasks.turn_steps] for task in step.tasks)
    return None if key.task in in_turn else sentence('belt_released')


def _what_is_unknown(key: e.TaskKey, task: Task) -> str:
    moved = 'placed' if task.qty_change == 1 else 'taken_out'
    return sentence(f'{moved}_unknown', item=key.item, section=key.section)


def _wanted(state: CellState, key: e.TaskKey) -> Words | None:
    """Say which results of a task later tasks of its item refer to: `mark_done` may give them."""
    if key.job is None or key.item is None:
        return None
    named = {
        '.'.join(reference.fields)
        for task in state.script(key.job).tasks.values()
        for reference in task.references
        if (reference.source, reference.name) == ('results', key.task)
    }
    return Words('wanted', {'fields': ', '.join(sorted(named))}) if named else None


def _policy(state: CellState, key: e.TaskKey, task: Task) -> OnFailure:
    failed = state.tasks[key]
    if failed.reason in (Reason.DUPLICATE_SERIAL, Reason.SETUP_MISSING):
        return OnFailure.HOLD  # a person has to look (5.3, 6.8)
    if not _is_settled(failed, task) or failed.cancel_cause in (SHUTDOWN, ABORT):
        return OnFailure.HOLD
    if _is_own_cancel(failed):
        return OnFailure.HOLD if _is_open(failed, task) else OnFailure.ABORT_JOB
    return task.on_failure


def _is_open(failed: TaskState, task: Task) -> bool:
    """Tell whether it is unknown if a task has placed its item, or taken it out (semantics 4.3).

    This is so if the attempt was cancelled while running, or was lost. With any other end the
    server itself reports that it was not done, and a goal never accepted has moved nothing.
    """
    if not task.qty_change or failed.reason in _NEVER_BEGUN or failed.never_begun:
        return False
    return _is_own_cancel(failed) or failed.reason in (Reason.IN_DOUBT, Reason.SERVER_LOST)


def _is_settled(failed: TaskState, task: Task) -> bool:
    """Tell whether the attempt has certainly ended (semantics 2.6)."""
    if failed.reason is Reason.SERVER_LOST:
        return task.repeatable
    return failed.reason is not Reason.IN_DOUBT


def _is_own_cancel(failed: TaskState) -> bool:
    """Tell whether the attempt ended by a cancel of the orchestrator (semantics 2.6).

    What fails while an aborted job drains is a failure like any other.
    """
    return failed.cancel_cause in (SHUTDOWN, ABORT, ABORT_JOB)


def _failure(state: CellState, key: e.TaskKey) -> str:
    failed = state.tasks[key]
    word = failed.reason.value if failed.reason else 'failed'
    return f'{word}, {failed.message}' if failed.message else word


def abort_all_on_the_belt(state: CellState, reason: str) -> Iterator[e.Event]:
    """Abort every job with something on the belt (semantics 3.5)."""
    for job in _jobs_on_the_belt(state):
        yield from effects.of_abort(state, job, reason)


def _jobs_on_the_belt(state: CellState) -> list[JobState]:
    """Return the jobs with something on the belt, in the order of the queue."""
    there = {state.items[s.slot].job for s in state.sections.values() if s.slot is not None}
    return [job for name, job in state.jobs.line.items() if name in there]
