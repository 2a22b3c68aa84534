"""The causes that keep a task from its next attempt (semantics 2.5, 4, 5.1, 7.1)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from bt_orchestrator.base.errors import MissingResult
from bt_orchestrator.model import effects
from bt_orchestrator.model.condition import Condition, holds
from bt_orchestrator.model.events import TaskKey
from bt_orchestrator.model.goal import NO_CONTEST, Contest
from bt_orchestrator.model.hold_words import hold_wait_words
from bt_orchestrator.model.jobs.setups import (
    change_id,
    changes_for,
    stays,
    untold,
    why_needless,
)
from bt_orchestrator.model.line import (
    barred_because,
    is_done_with,
    may_not_begin,
    stopped_because,
    waits_for_earlier_jobs,
    waits_for_readiness,
    waits_for_service,
    waits_for_tasks,
)
from bt_orchestrator.model.reference import resolve
from bt_orchestrator.model.script import Dependency, Task
from bt_orchestrator.model.state import CellState, Cycle, JobState, Phase, same_args, same_task
from bt_orchestrator.model.wait import Wait, WaitKind
from bt_orchestrator.model.words import sentence


class Seen(Protocol):
    """The present facts of servers and clocks, which the state does not have."""

    def rivals(self, component: str) -> Sequence[str]:
        """Return the present servers of a component's action, if there are several."""

    def is_delayed(self, key: TaskKey) -> bool:
        """Tell whether the next attempt of a task waits for its delay."""

    def awaits_setup(self, key: TaskKey) -> bool:
        """Tell whether a task still waits for a state topic to tell its setup (semantics 5.3)."""


def before_attempt(state: CellState, key: TaskKey, task: Task, seen: Seen) -> Wait | str | None:
    """Return what the next attempt waits for, or why the task is skipped; None: it may start.

    The guards around the task are not asked here.
    """
    # Asked also in a stopped section: the cell is not Held before this time.
    progress = state.tasks.get(key)
    is_delayed = progress is not None and seen.is_delayed(key)
    if key.section is not None or not ends_with_its_job(state, key, task):
        stopped = stopped_task(state, key)
        if stopped is not None:
            return stopped
    skipped = why_skipped(state, key, task)
    if skipped is not None:
        return skipped
    if progress is not None and is_delayed:
        return Wait(f'waiting to retry, attempt {progress.attempt + 1}', WaitKind.RETRY_DELAY)
    if task.setup:
        wait = _waits_for_component(state, key, task, seen) or _waits_for_change(state, key, task)
        return wait or _waits_to_be_told(state, key, task, seen)
    return _waits_for_component(state, key, task, seen)


def _waits_for_change(state: CellState, key: TaskKey, task: Task) -> Wait | None:
    """Say that the setup which a task lacks is being changed (semantics 5.3)."""
    for change in changes_for(state, key, task):
        if state.phase(change) not in (None, Phase.DONE):
            what = f'waiting for initialization {change.task} of {key.job}'
            return Wait(what, WaitKind.INITIALIZATION, change.task, task=change.task)
    return None


def _waits_to_be_told(state: CellState, key: TaskKey, task: Task, seen: Seen) -> Wait | None:
    """Say that a state topic does not tell the setup yet (semantics 5.3)."""
    mismatch = untold(state, task)
    if mismatch is None or not seen.awaits_setup(key):
        return None
    setup, value = mismatch
    wanted, topic = task.setup[setup], state.cell.components[task.component].state
    says = f'it is {value}' if value else 'nothing is published there'
    change = change_id(task.component, setup, wanted)
    what = f'waiting for {topic and topic.topic} to tell {setup} {wanted}; {says}'
    return Wait(what, WaitKind.INITIALIZATION, change, task=change)


def _waits_for_component(state: CellState, key: TaskKey, task: Task, seen: Seen) -> Wait | None:
    unavailable = waits_for_service(state, task.component)
    if unavailable is not None:
        return unavailable
    busy = state.reserved.get(task.component)
    if busy is not None and busy != key:  # else kept for its retry (4.4)
        what = f'waiting for {task.component}, busy with {_holder(state, busy)}'
        return Wait(what, WaitKind.COMPONENT, task.component, _section_of(busy), busy.task)
    return waits_for_one_server(state, task.component, seen)


def waits_for_one_server(state: CellState, component: str, seen: Seen) -> Wait | None:
    """Name the others who have a part in a component now (semantics 2.5); None: no other.

    It looks at the servers too: the event for what is seen now comes only later.
    """
    contest = state.contests.get(component)
    if not contest:
        rivals = seen.rivals(component)
        contest = Contest(tuple(rivals)) if rivals else NO_CONTEST
    if not contest:
        return None
    action = state.cell.components[component].action
    return Wait(contest.wait(component, action), WaitKind.READINESS, component)


# --- guards -------------------------------------------------------------------------------------


def waits_for_belt(state: CellState, cycle: Cycle) -> Wait | None:
    """Say that the belt moves, or is at rest in the beat before that of a cycle (3.3, 3.7)."""
    rests = not state.indexing
    if rests and state.beat == cycle.beat:
        return None
    return Wait(f'waiting for the belt to {"move" if rests else "rest"}', WaitKind.BELT)


def waits_for_flag(state: CellState, key: TaskKey, dependency: Dependency) -> Wait | None:
    """Say what a flag waits for (4.1); also for a task that will be skipped (4.2)."""
    if not effects.is_startable(state, key):
        return None
    count = state.flags[dependency.flag].count
    if dependency.upstream == key.task:
        full = count >= dependency.capacity
        return _until(state, key, dependency.flag, dependency.downstream, 'take') if full else None
    lacks = count <= 0
    return _until(state, key, dependency.flag, dependency.upstream, 'set') if lacks else None


def _until(state: CellState, key: TaskKey, flag: str, task: str, does: str) -> Wait:
    assert key.job is not None
    section = state.script(key.job).section_of(task)
    what = f'waiting for {task} to {does} flag {flag}'
    return Wait(what, WaitKind.FLAG, flag, (section,), task)


def waits_for_zone(state: CellState, key: TaskKey, task: Task, zone: str) -> Wait | None:
    """Say which task is in a zone (4.4); a held task keeps it until its new attempt."""
    there = state.zones.get(zone)
    if there is None or there == key or not waits_to_start(state, key, task):
        return None
    what = f'waiting for zone {zone}, taken by {_holder(state, there)}'
    return Wait(what, WaitKind.ZONE, zone, _section_of(there), there.task)


def waits_for_topic(state: CellState, key: TaskKey, task: Task) -> Wait | None:
    """Say what the state topic of the component does not say (2.5)."""
    wait = waits_for_readiness(state, task.component)
    return wait if wait is not None and waits_to_start(state, key, task) else None


def waits_for_preparation(state: CellState, key: TaskKey, task: Task) -> Wait | None:
    """Say what an initialization task waits for: other tasks, and the jobs in front (5)."""
    assert key.job is not None
    if state.phase(key) is not None or ends_with_its_job(state, key, task):
        return None
    stopped = may_not_prepare(state, key.job)
    if stopped is not None:
        return stopped
    if done_before(state, key, task) is not None and remains_done(state, key.job, task):
        return None
    return waits_for_its_turn(state, key.job, task)


# --- what may be skipped, and what is stopped ----------------------------------------------------


def waits_to_start(state: CellState, key: TaskKey, task: Task) -> bool:
    """Tell whether the next step is to start an attempt: neither begun nor to be skipped."""
    return effects.is_startable(state, key) and why_skipped(state, key, task) is None


def why_skipped(state: CellState, key: TaskKey, task: Task) -> str | None:
    """Say why a task that may start is not needed (semantics 4.2, 5.1, 6.4, 6.5)."""
    if key.job is None:
        return None
    reason = effects.why_skipped(state, key, task)
    if reason is None and task.once:
        reason = done_before(state, key, task)
    if reason is None and task.condition is not None:
        reason = _unmet(state, key, task.condition)
    return reason


def ends_with_its_job(state: CellState, key: TaskKey, task: Task) -> bool:
    """Tell whether it is an initialization task of a job that is ending (6.6).

    Nothing waits for it, so it is skipped whatever the state of the cell.
    """
    if key.section is not None or key.job is None:
        return False
    return effects.why_skipped(state, key, task) is not None


def done_before(state: CellState, key: TaskKey, task: Task) -> str | None:
    """Say that the same task is already done and need not be repeated (5.1, 5.3)."""
    if not task.once:
        return None
    if task.is_implied:
        return why_needless(state, key, task)
    args = resolve(task.args, state.scope(key))
    done = state.done_once.get(same_task(task))
    return 'done before' if done == same_args(args) else None


def _unmet(state: CellState, key: TaskKey, condition: Condition) -> str | None:
    """Say that a condition is not met. If a value is missing, the attempt fails instead."""
    try:
        return None if holds(condition, state.scope(key)) else str(condition)
    except MissingResult:
        return None


def stopped_task(state: CellState, key: TaskKey) -> Wait | None:
    """Say why the task must not start or be skipped: a skip counts as if it had run."""
    if not state.works:
        mode = state.packml.value
        what = barred_because(state) if state.barred else sentence('cell_is', state=mode)
        return Wait(what, WaitKind.CELL_STATE, mode)
    if not state.holds:
        return None
    if state.stops:
        first = state.stops[0]
        return Wait(hold_wait_words([first]), WaitKind.PAUSE, first.id)
    return waits_in_hold(state, key)


def waits_in_hold(state: CellState, key: TaskKey) -> Wait | None:
    """Return the wait for a hold that blocks the task's section (semantics 7.1)."""
    for hold in state.holds.values():
        same = (
            not hold.is_pause
            and hold.section == key.section
            and (hold.job is None) == (key.job is None)
        )
        if same:
            return Wait(hold_wait_words([hold]), WaitKind.HOLD, hold.id)
    return None


def _holder(state: CellState, key: TaskKey) -> str:
    """Name the task that has a component or a zone, and why, if its goal does not run."""
    has = state.tasks[key]
    if has.phase is Phase.HELD:
        return f'{key}, which waits for an answer to hold {has.hold}'
    if has.phase is Phase.RETRYING:
        return f'{key}, which is to be tried again'
    return str(key)


def _section_of(key: TaskKey) -> tuple[int, ...]:
    """Return the section that works on a task; none for initialization and the belt's move."""
    return () if key.section is None else (key.section,)


# When a task of an initialization may start, or be skipped (semantics 5).


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
        _prepares(state, earlier, task) or _does(state, earlier, task) for earlier in before
    )


def _prepares(state: CellState, job: JobState, task: Task, *, besides: str = '') -> bool:
    """Tell whether initialization of a job is still to do the same task.

    :param besides: id of a task of this job that does not count. Jobs of one script share its
        `Task` objects, so identity would leave out the tasks of earlier jobs too.
    """
    name = job.job.id
    return any(
        other.id != besides and same_task(other) == same_task(task)
        for other in job.job.script.initialization
        if not _is_prepared(state, name, other.id)
    )


def _does(state: CellState, job: JobState, task: Task) -> bool:
    """Tell whether a section may still do the same task for a job."""
    return any(
        same_task(other) == same_task(task)
        for number, tasks in job.job.script.sections.items()
        if not is_done_with(state, state.sections[number], job)
        for other in tasks.tasks
    )


def _is_prepared(state: CellState, job: str, task: str) -> bool:
    return state.phase(TaskKey(job, None, None, task)) is Phase.DONE
