"""How events of tasks change the state: attempts, ends, and reserved resources."""

from __future__ import annotations

from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import OnFailure
from bt_orchestrator.model.failures import will_hold
from bt_orchestrator.model.folds.cell_folds import note_uptime
from bt_orchestrator.model.folds.line import mark_nonconforming
from bt_orchestrator.model.frozen import changed, shared
from bt_orchestrator.model.goal import Reason
from bt_orchestrator.model.jobs.job_folds import forget_skips
from bt_orchestrator.model.jobs.setups import forget, forget_all, learn
from bt_orchestrator.model.judging.rejects import count_reject
from bt_orchestrator.model.script import Task, index_task
from bt_orchestrator.model.state import (
    CellState,
    End,
    ManualRun,
    Phase,
    TaskState,
    same_args,
    same_task,
)


def task_started(event: e.TaskStarted, state: CellState) -> None:
    started = TaskState(
        Phase.RUNNING,
        attempt=event.attempt,
        goal=event.goal,
        started=event.time,
        args=event.args,
        sent=event.time,
        server=event.server,
        sent_up=note_uptime(event, state),
        sent_seq=event.seq,
    )
    key = event.key
    state.tasks[key] = state.running[key] = started
    _forget_done(state, key)  # until it succeeds its effect is unknown
    if key == e.MANUAL_KEY:
        state.reserved.setdefault(event.component, key)  # a held task keeps it
        return
    state.reserved[event.component] = key
    for zone in _zones(state, key):
        state.zones[zone] = key


def task_of(state: CellState, key: e.TaskKey) -> Task:
    """Return the task that a key names, the belt's own move too."""
    return state.task(key) or index_task(state.cell)


def task_adopted(event: e.TaskAdopted, state: CellState) -> None:
    assert state.running[event.key].goal == event.goal


def task_resent(event: e.TaskResent, state: CellState) -> None:
    before = state.running[event.key]
    assert before.goal == event.goal
    up = note_uptime(event, state)
    sent = changed(before, sent=event.time, server=event.server, sent_up=up, sent_seq=event.seq)
    state.tasks[event.key] = state.running[event.key] = sent


def task_cancel_requested(event: e.TaskCancelRequested, state: CellState) -> None:
    task = changed(state.tasks[event.key], cancel_cause=event.cause, cancelled_at=event.time)
    state.tasks[event.key] = state.running[event.key] = task


def task_failed(event: e.TaskFailed, state: CellState) -> None:
    reason = Reason(event.reason)
    before = state.tasks.get(event.key) or TaskState(Phase.FAILED)
    state.running.pop(event.key, None)
    state.tasks[event.key] = changed(
        before,
        phase=Phase.FAILED,
        attempt=event.attempt,
        reason=reason,
        message=event.message,
        refused=event.results,
        controller_said=event.controller_said,
        last_feedback=event.last_feedback,
        topic_says=event.topic_says,
        never_begun=event.never_begun,
    )
    # While an operator is asked, the robot stays where it stopped (semantics 4.4).
    if not will_hold(state, event.key, task_of(state, event.key)):
        _release(state, event.key)
    if reason is Reason.SETUP_MISSING:
        _free_component(state, event.key)  # the change needs it (5.3)
    if event.key == e.MANUAL_KEY:
        _manual_ended(state, event, reason.value)


def round_begun(event: e.RoundBegun, state: CellState) -> None:
    section = state.sections[event.section]
    assert section.cycle is not None
    cycle = section.cycle
    section.cycle = changed(
        cycle,
        rounds={**cycle.rounds, event.repeat: event.n},
        round_causes={**cycle.round_causes, event.repeat: _round_cause(event, state)},
    )
    for name in event.tasks:
        key = e.TaskKey(event.job, event.section, event.item, name)
        _release(state, key)
        state.tasks.pop(key, None)
        state.items[event.item].results.pop(name, None)


def _round_cause(event: e.RoundBegun, state: CellState) -> str:
    """Return the failed task of a repeat, with what its record says."""
    for name in event.tasks:
        failed = state.tasks.get(e.TaskKey(event.job, event.section, event.item, name))
        if failed is not None and failed.phase is not Phase.DONE and failed.reason is not None:
            return f'{name}: {failed.message or failed.reason.value}'
    return ''


def task_retrying(event: e.TaskRetrying, state: CellState) -> None:
    state.tasks[event.key] = changed(
        state.tasks[event.key],
        phase=Phase.RETRYING,
        not_before=event.not_before,
        delay_s=max(0.0, event.not_before - event.time),
        delayed_up=note_uptime(event, state),
        cancel_cause=None,
        hold=None,
    )


def task_succeeded(event: e.TaskSucceeded, state: CellState) -> None:
    if event.key == e.MANUAL_KEY:
        _end(state, event.key, End.DONE)
        _manual_ended(state, event, End.DONE.value)
        return
    _succeed(state, event.key, End.DONE)
    _keep_results(state, event)


def manual_asked(event: e.ManualAsked, state: CellState) -> None:
    """Forget what the component is set up for, and that its initialization is done."""
    state.manual = ManualRun(asked=event.time, **shared(event, ManualRun))
    state.tasks.pop(e.MANUAL_KEY, None)
    action = state.cell.components[event.component].action
    for done in [key for key in state.done_once if key.startswith(f'{action} ')]:
        del state.done_once[done]
    forget_all(state, event.component)
    forget_skips(state, lambda job: not job.progress.started)
    held = state.holds.get(event.hold)
    if held is not None:
        state.holds[held.id] = changed(held, manual=(*held.manual, event.name))


def _manual_ended(state: CellState, event: e.TaskSucceeded | e.TaskFailed, end: str) -> None:
    run = state.manual
    assert run is not None
    state.manual = changed(run, ended=event.time, results=event.results)
    held = state.holds.get(run.hold)
    if held is not None:
        *before, last = held.manual
        state.holds[held.id] = changed(held, manual=(*before, f'{last}: {end}'))
    if end != End.DONE.value and will_hold(state, event.key, task_of(state, event.key)):
        state.reserved.setdefault(run.component, event.key)


def _keep_results(state: CellState, event: e.TaskSucceeded | e.TaskMarkedDone) -> None:
    if event.item is not None and event.results:
        state.items[event.item].results[event.task] = event.results


def task_marked_done(event: e.TaskMarkedDone, state: CellState) -> None:
    _forget_done(state, event.key)
    _succeed(state, event.key, End.MARKED_DONE)
    _keep_results(state, event)


def task_skipped(event: e.TaskSkipped, state: CellState) -> None:
    _end(state, event.key, End.SKIPPED)
    state.tasks[event.key] = changed(state.tasks[event.key], reason=None, message=event.reason)


def task_continued(event: e.TaskContinued, state: CellState) -> None:
    if event.policy == OnFailure.REJECT.value:
        count_reject(state, event.key)
    _end(state, event.key, _ENDS[event.policy])
    if event.nonconforming is None:
        return
    mark_nonconforming(state, event.nonconforming, event.task)
    refused = state.tasks[event.key].refused
    if refused:
        state.items[event.nonconforming].results[event.task] = refused


_ENDS = {
    OnFailure.CONTINUE.value: End.CONTINUED,
    OnFailure.REJECT.value: End.REJECTED,
    OnFailure.ABORT_JOB.value: End.ABORTED,
}


def _succeed(state: CellState, key: e.TaskKey, end: End) -> None:
    task, progress = state.task(key), state.tasks[key]
    if task is not None:
        if progress.goal is not None:
            state.done_once[same_task(task)] = same_args(progress.args)
        if task.change is not None:
            learn(state, task, progress.server)
    _end(state, key, end)


def _forget_done(state: CellState, key: e.TaskKey) -> None:
    """Forget the arguments of a task's last success, wherever it ran (semantics 5.1)."""
    task = state.task(key)
    if task is not None:
        state.done_once.pop(same_task(task), None)
        if task.change is not None:
            forget(state, task.component, task.change.setup)


def _end(state: CellState, key: e.TaskKey, end: End) -> None:
    _release(state, key)
    state.running.pop(key, None)
    before = state.tasks.get(key) or TaskState(Phase.DONE)
    state.tasks[key] = changed(before, phase=Phase.DONE, hold=None, end=end)


def _release(state: CellState, key: e.TaskKey) -> None:
    """Free the component and the zones that a task has, if it still has them."""
    _free_component(state, key)
    for zone in _zones(state, key):
        if state.zones.get(zone) == key:
            del state.zones[zone]


def _free_component(state: CellState, key: e.TaskKey) -> None:
    task = state.task(key)
    component = task.component if task else state.cell.conveyor.component.name
    if state.reserved.get(component) == key:
        del state.reserved[component]


def _zones(state: CellState, key: e.TaskKey) -> tuple[str, ...]:
    return () if key.job is None else state.script(key.job).zones_of.get(key.task, ())
