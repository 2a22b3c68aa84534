"""The fold: how each event changes the state. Nothing else changes it."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from bt_orchestrator.model import cell_folds as cell
from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import OnFailure
from bt_orchestrator.model.failures import answers, will_hold
from bt_orchestrator.model.frozen import changed
from bt_orchestrator.model.goal import Reason
from bt_orchestrator.model.jobs import job_folds as jobs
from bt_orchestrator.model.script import index_task
from bt_orchestrator.model.state import (
    CellState,
    Cycle,
    End,
    Hold,
    ItemState,
    Phase,
    Reading,
    TaskState,
    same_args,
    same_task,
)
from bt_orchestrator.model.uptime import Uptime

ON_THE_BELT = {
    e.ItemPlaced,
    e.ItemMissing,
    e.ItemMoved,
    e.ItemRemoved,
    e.PositionEnded,
    e.BeltIndexStarted,
    e.BeltIndexed,
}
"""Events after which another picture of the belt is true."""


CHANGE_ANSWERS = {
    e.ItemRejected,
    e.ItemMissing,
    e.ItemRemoved,
    e.PositionEnded,
    e.JobAborting,
    e.JobStopping,
}
"""Events after which a hold may offer other answers than before."""


def apply(state: CellState, event: e.Event) -> None:
    """Change the state by one event.

    :raises AssertionError: the event cannot have happened in this state
    """
    assert event.seq == state.seq + 1, f'event {event.seq} after {state.seq}'
    fold = _FOLDS.get(type(event))
    assert fold is not None, f'no fold for {type(event).__name__} at event {state.seq}'
    fold(event, state)
    state.seq, state.time = event.seq, event.time
    if type(event) in ON_THE_BELT:
        state.belt_seq = event.seq
    if state.holds and type(event) in CHANGE_ANSWERS:
        _offer_anew(state)


_Fold = TypeVar('_Fold', bound=Callable[..., None])

_FOLDS: dict[type[e.Event], Callable[..., None]] = {}


def _on(*kinds: type[e.Event]) -> Callable[[_Fold], _Fold]:
    """Register the fold of one or several event classes."""

    def register(fold: _Fold) -> _Fold:
        for kind in kinds:
            _FOLDS[kind] = fold
        return fold

    return register


# --- jobs -----------------------------------------------------------------------------------


_on(e.ScriptLoaded)(jobs.script_loaded)
_on(e.JobQueued)(jobs.job_queued)
_on(e.JobMoved)(jobs.job_moved)
_on(e.JobUpdated)(jobs.job_updated)
_on(e.JobHeld)(jobs.job_held)
_on(e.JobReleased)(jobs.job_released)
_on(e.JobRemoved)(jobs.job_removed)
_on(e.QueueStopRequested)(jobs.queue_stop_requested)
_on(e.QueueStopCancelled)(jobs.queue_stop_cancelled)
_on(e.QueueStopReached)(jobs.queue_stop_reached)
_on(e.JobStarted)(jobs.job_started)
_on(e.JobPaused)(jobs.job_paused)
_on(e.JobResumed)(jobs.job_resumed)
_on(e.JobStopping)(jobs.job_stopping)
_on(e.JobAborting)(jobs.job_aborting)
_on(e.JobCompleted, e.JobAborted)(jobs.job_ended)
_on(e.JobCleared)(jobs.job_cleared)


# --- tasks ----------------------------------------------------------------------------------


@_on(e.TaskStarted)
def _task_started(event: e.TaskStarted, state: CellState) -> None:
    started = TaskState(
        Phase.RUNNING,
        attempt=event.attempt,
        goal=event.goal,
        started=event.time,
        args=event.args,
        sent=event.time,
        server=event.server,
        sent_up=_up(event, state),
    )
    state.tasks[event.key] = state.running[event.key] = started
    _forget_done(state, event.key)  # until it succeeds nobody knows what it leaves behind
    state.reserved[event.component] = event.key
    for zone in _zones(state, event.key):
        state.zones[zone] = event.key


@_on(e.TaskAdopted)
def _task_adopted(event: e.TaskAdopted, state: CellState) -> None:
    assert state.running[event.key].goal == event.goal


@_on(e.TaskResent)
def _task_resent(event: e.TaskResent, state: CellState) -> None:
    before = state.running[event.key]
    assert before.goal == event.goal
    up = _up(event, state)
    sent = changed(before, sent=event.time, server=event.server, sent_up=up)
    state.tasks[event.key] = state.running[event.key] = sent


def _up(event: e.TaskStarted | e.TaskResent | e.TaskRetrying, state: CellState) -> Uptime | None:
    return Uptime(state.boot, event.uptime) if state.boot and event.uptime is not None else None


@_on(e.TaskCancelRequested)
def _task_cancel_requested(event: e.TaskCancelRequested, state: CellState) -> None:
    task = changed(state.tasks[event.key], cancel_cause=event.cause, cancelled_at=event.time)
    state.tasks[event.key] = state.running[event.key] = task


@_on(e.TaskFailed)
def _task_failed(event: e.TaskFailed, state: CellState) -> None:
    reason = Reason(event.reason)
    before = state.tasks.get(event.key, TaskState(Phase.FAILED))
    state.running.pop(event.key, None)
    state.tasks[event.key] = changed(
        before,
        phase=Phase.FAILED,
        attempt=event.attempt,
        reason=reason,
        message=event.message,
    )
    # Where an operator is asked, the robot stands where it stopped (semantics 4.4).
    if not will_hold(state, event.key, state.task(event.key) or index_task(state.cell)):
        _release(state, event.key)


@_on(e.TaskRetrying)
def _task_retrying(event: e.TaskRetrying, state: CellState) -> None:
    state.tasks[event.key] = changed(
        state.tasks[event.key],
        phase=Phase.RETRYING,
        not_before=event.not_before,
        delay_s=max(0.0, event.not_before - event.time),
        delayed_up=_up(event, state),
        cancel_cause=None,
        hold=None,
    )


@_on(e.TaskSucceeded)
def _task_succeeded(event: e.TaskSucceeded, state: CellState) -> None:
    _succeed(state, event.key, End.DONE)
    _keep_results(state, event)


def _keep_results(state: CellState, event: e.TaskSucceeded | e.TaskMarkedDone) -> None:
    if event.item is not None and event.results:
        state.items[event.item].results[event.task] = event.results


@_on(e.TaskMarkedDone)
def _task_marked_done(event: e.TaskMarkedDone, state: CellState) -> None:
    _forget_done(state, event.key)
    _succeed(state, event.key, End.MARKED_DONE)
    _keep_results(state, event)


@_on(e.TaskSkipped)
def _task_skipped(event: e.TaskSkipped, state: CellState) -> None:
    _end(state, event.key, End.SKIPPED)
    state.tasks[event.key] = changed(state.tasks[event.key], reason=None, message=event.reason)


@_on(e.TaskContinued)
def _task_continued(event: e.TaskContinued, state: CellState) -> None:
    _end(state, event.key, _ENDS[event.policy])
    if event.item is None or event.policy != OnFailure.CONTINUE.value:
        return
    item = state.items[event.item]
    if not item.nonconforming:
        state.jobs[item.job].progress.nonconforming += 1
    item.nonconforming.append(event.task)


_ENDS = {
    OnFailure.CONTINUE.value: End.CONTINUED,
    OnFailure.REJECT.value: End.REJECTED,
    OnFailure.ABORT_JOB.value: End.ABORTED,
}


def _succeed(state: CellState, key: e.TaskKey, end: End) -> None:
    task, progress = state.task(key), state.tasks[key]
    if task is not None and progress.goal is not None:
        state.done_once[same_task(task)] = same_args(progress.args)
    _end(state, key, end)


def _forget_done(state: CellState, key: e.TaskKey) -> None:
    """Forget with which arguments a task was done last, wherever it ran (semantics 5.1)."""
    task = state.task(key)
    if task is not None:
        state.done_once.pop(same_task(task), None)


def _end(state: CellState, key: e.TaskKey, end: End) -> None:
    _release(state, key)
    state.running.pop(key, None)
    before = state.tasks.get(key, TaskState(Phase.DONE))
    state.tasks[key] = changed(before, phase=Phase.DONE, hold=None, end=end)


def _release(state: CellState, key: e.TaskKey) -> None:
    """Free the component and the zones that a task has, if it still has them."""
    task = state.task(key)
    component = task.component if task else state.cell.conveyor.component.name
    if state.reserved.get(component) == key:
        del state.reserved[component]
    for zone in _zones(state, key):
        if state.zones.get(zone) == key:
            del state.zones[zone]


def _zones(state: CellState, key: e.TaskKey) -> tuple[str, ...]:
    return () if key.job is None else state.script(key.job).zones_of.get(key.task, ())


# --- cycles, flags, the belt ----------------------------------------------------------------


@_on(e.CycleStarted)
def _cycle_started(event: e.CycleStarted, state: CellState) -> None:
    job = state.jobs[event.job]
    if event.item not in state.items:
        job.progress.started += 1
        item = ItemState(event.item, event.job, job.progress.started)
        state.items[event.item] = job.items[event.item] = item
    state.items[event.item].open_cycles += 1
    state.sections[event.section].cycle = Cycle(event.job, event.item, event.beat)


@_on(e.TurnCompleted)
def _turn_completed(event: e.TurnCompleted, state: CellState) -> None:
    section = state.sections[event.section]
    assert section.cycle is not None
    section.turn_beat = section.cycle.beat


@_on(e.CycleCompleted)
def _cycle_completed(event: e.CycleCompleted, state: CellState) -> None:
    state.sections[event.section].cycle = None
    script = state.script(event.job)
    for task in script.sections[event.section].tasks:
        del state.tasks[e.TaskKey(event.job, event.section, event.item, task.id)]
    item = state.items[event.item]
    if event.section == script.last_before_sink and item.present and not item.rejected:
        state.jobs[event.job].progress.processed += 1
    item.open_cycles -= 1
    _forget_if_gone(state, item)


@_on(e.FlagRaised, e.FlagLowered)
def _flag_changed(event: e.FlagRaised | e.FlagLowered, state: CellState) -> None:
    state.flags[event.flag].count = event.count


@_on(e.BeatStarted)
def _beat_started(event: e.BeatStarted, state: CellState) -> None:
    state.beat = event.beat


@_on(e.BeltIndexStarted)
def _belt_index_started(_: e.BeltIndexStarted, state: CellState) -> None:
    state.indexing = True


@_on(e.BeltIndexed)
def _belt_indexed(event: e.BeltIndexed, state: CellState) -> None:
    state.indexing = False
    state.beat = event.beat
    del state.tasks[e.INDEX_KEY]


# --- items ----------------------------------------------------------------------------------


@_on(e.ItemPlaced)
def _item_placed(event: e.ItemPlaced, state: CellState) -> None:
    _stand(state, event.item, event.section)
    state.jobs[event.job].progress.placed += 1


@_on(e.ItemMissing)
def _item_missing(event: e.ItemMissing, state: CellState) -> None:
    _stand(state, event.item, event.section)
    state.items[event.item].present = False
    state.jobs[event.job].progress.missing += 1


@_on(e.ItemMoved)
def _item_moved(event: e.ItemMoved, state: CellState) -> None:
    state.sections[state.items[event.item].section].slot = None
    _stand(state, event.item, event.section)


@_on(e.ItemRejected)
def _item_rejected(event: e.ItemRejected, state: CellState) -> None:
    state.items[event.item].rejected = True


@_on(e.ItemRemoved)
def _item_removed(event: e.ItemRemoved, state: CellState) -> None:
    item = state.items[event.item]
    progress = state.jobs[event.job].progress
    if event.how == 'by_hand':
        item.present = False
        progress.missing += 1
        progress.removed += 1
        return
    if event.how == 'rejected':
        progress.rejected += 1
    else:
        progress.packed += 1
    if event.section == state.script(event.job).sink:
        _leave(state, item)
        return
    item.present = False
    progress.processed += event.how == 'packed'


@_on(e.PositionEnded)
def _position_ended(event: e.PositionEnded, state: CellState) -> None:
    _leave(state, state.items[event.item])


def _stand(state: CellState, item: str, section: int) -> None:
    assert state.sections[section].slot is None, f'two items in slot {section}'
    state.sections[section].slot = item
    state.items[item].section = section


def _leave(state: CellState, item: ItemState) -> None:
    state.sections[item.section].slot = None
    item.section = 0
    item.gone = True
    _forget_if_gone(state, item)


def _forget_if_gone(state: CellState, item: ItemState) -> None:
    if item.gone and item.open_cycles == 0:
        del state.items[item.id]
        del state.jobs[item.job].items[item.id]


# --- components, holds, the cell ------------------------------------------------------------


@_on(e.ComponentStateChanged)
def _component_state_changed(event: e.ComponentStateChanged, state: CellState) -> None:
    state.readings[event.component] = Reading(event.ready, event.value)


_on(e.ComponentContested)(cell.component_contested)


@_on(e.HoldRaised)
def _hold_raised(event: e.HoldRaised, state: CellState) -> None:
    hold = Hold(
        id=event.hold,
        job=event.job,
        section=event.section,
        item=event.item,
        task=event.task,
        reason=event.reason,
        message=event.message,
        answers=event.answers,
        since=event.time,
        owner=event.owner,
        name=event.name,
        component=event.component,
        action=event.action,
        attempt=event.attempt,
        attempts=event.attempts,
    )
    state.holds[hold.id] = hold
    state.holds_raised += 1
    if hold.key is not None:
        before = state.tasks.get(hold.key, TaskState(Phase.HELD))
        state.tasks[hold.key] = changed(before, phase=Phase.HELD, hold=hold.id)


def _offer_anew(state: CellState) -> None:
    """Let every held task offer what makes sense for its item and its job as they are now."""
    for name, hold in state.holds.items():
        key = hold.key
        if key is not None and state.tasks[key].reason is not None:
            task = state.task(key) or index_task(state.cell)
            state.holds[name] = changed(hold, answers=answers(state, key, task))


@_on(e.HoldReleased)
def _hold_released(event: e.HoldReleased, state: CellState) -> None:
    del state.holds[event.hold]


@_on(e.OperatorRefused, e.RequestRefused)
def _refused(_: e.Event, state: CellState) -> None:
    """Change nothing."""


_on(e.OperatorDecided)(cell.operator_decided)
_on(e.OrchestratorStarted)(cell.orchestrator_started)
_on(e.OrchestratorStopping)(cell.orchestrator_stopping)
_on(e.StopReasonChanged)(cell.stop_reason_changed)
_on(e.CellStateChanged)(cell.cell_state_changed)
_on(e.ClockStepped)(cell.clock_stepped)
