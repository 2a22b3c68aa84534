"""How the events of the cell as a whole, and of holds, change the state; part of `model.fold`."""

from __future__ import annotations

from typing import TypeAlias

from bt_orchestrator.model import events as e
from bt_orchestrator.model.by import Control
from bt_orchestrator.model.failures import answers, why_not_offered
from bt_orchestrator.model.frozen import changed, shared
from bt_orchestrator.model.goal import Contest
from bt_orchestrator.model.jobs.job_folds import forget_skips, note_work
from bt_orchestrator.model.jobs.setups import forget_all, note_told
from bt_orchestrator.model.judging.rejects import forget_rejects, note_hold
from bt_orchestrator.model.packml import PackmlState, UnitMode
from bt_orchestrator.model.requests.offers import together
from bt_orchestrator.model.script import index_task
from bt_orchestrator.model.state import CellState, Hold, OutOfService, Phase, Reading, TaskState
from bt_orchestrator.model.stop_reason import (
    STAND,
    START,
    STOP_AFTER,
    TOO_MANY_REJECTS,
    StopReason,
    Wish,
)
from bt_orchestrator.model.uptime import ClockReading, Uptime
from bt_orchestrator.model.words import facts_of

Timed: TypeAlias = e.TaskStarted | e.TaskResent | e.TaskRetrying | e.ClockStepped
"""Events that say how long the machine had been up."""

_FORGET_ONCE = (PackmlState.STOPPED, PackmlState.ABORTED)
"""States in which an operator may have moved anything by hand (semantics 5.1)."""


def component_state_changed(event: e.ComponentStateChanged, state: CellState) -> None:
    """Store the value of a state topic."""
    state.readings[event.component] = Reading(event.ready, event.value)


def orchestrator_started(event: e.OrchestratorStarted, state: CellState) -> None:
    """Continue from the last one's end; the time between counts for no PackML state."""
    if state.seq:
        _stay(state, state.time)
    state.packml_since = event.time
    state.cell_digest, state.history, state.boot = event.digest, event.history, event.boot
    if event.restored or event.missing:
        for key, task in state.running.items():
            state.tasks[key] = state.running[key] = changed(task, copied=True)
    state.shutting_down = False
    state.barred = bool(state.unsafe)
    state.contests.clear()  # not checked yet
    state.setups_told.clear()  # no message yet
    # Older journals have skips of jobs that have not started.
    forget_skips(state, lambda job: not job.started)


def component_contested(event: e.ComponentContested, state: CellState) -> None:
    """Store the contest of a component."""
    contest = Contest(event.servers, event.goals)
    state.contests.pop(event.component, None)
    if contest:
        state.contests[event.component] = contest
    if event.goals:
        forget_all(state, event.component)


def component_setup_lost(event: e.ComponentSetupLost, state: CellState) -> None:
    """Forget what its controller was set up for."""
    forget_all(state, event.component)


def component_setup_read(event: e.ComponentSetupRead, state: CellState) -> None:
    """Keep what the state topic tells of a setup."""
    note_told(state, event.component, event.setup, event.value)


def component_out_of_service(event: e.ComponentOutOfService, state: CellState) -> None:
    """Let it get no goal, and let later jobs pass the jobs that need it."""
    state.out_of_service[event.component] = OutOfService(event.reason, event.time)
    forget_all(state, event.component)
    for job in event.jobs:
        state.jobs.lack(job, (*state.jobs.queued(job).unavailable, event.component))


def component_in_service(event: e.ComponentInService, state: CellState) -> None:
    """Let it get goals; for the cell the jobs that lack no other one are like new orders."""
    del state.out_of_service[event.component]
    for job in state.queue:
        if event.component in job.unavailable:
            left = tuple(
                component for component in job.unavailable if component != event.component
            )
            state.jobs.lack(job.job.id, left)
            note_work(state, state.jobs.queued(job.job.id))


def orchestrator_stopping(_: e.OrchestratorStopping, state: CellState) -> None:
    """Block every start."""
    state.shutting_down = state.barred = True


def stop_reason_changed(event: e.StopReasonChanged, state: CellState) -> None:
    """Set the stop reason, or none."""
    state.stop_reason = StopReason(event.stop_reason) if event.stop_reason else None
    state.stop_message = event.reason


def safety_changed(event: e.SafetyChanged, state: CellState) -> None:
    """Let goals start, or none; what has to be done besides are events of their own."""
    state.unsafe = event.reason
    state.barred = state.shutting_down or bool(state.unsafe)


def control_changed(event: e.ControlChanged, state: CellState) -> None:
    """Set from where the line may be moved."""
    state.control = Control(event.control)


def unit_mode_changed(event: e.UnitModeChanged, state: CellState) -> None:
    """Enter manual mode, or leave it: then its last goal is forgotten."""
    state.unit_mode, state.manual = UnitMode(event.mode), None
    state.tasks.pop(e.MANUAL_KEY, None)


def request_signed(event: e.RequestSigned, state: CellState) -> None:
    """Keep the number of a key: it is used (semantics 7.12)."""
    state.signatures[event.public] = event.number


def cell_state_changed(event: e.CellStateChanged, state: CellState) -> None:
    """Enter another PackML state."""
    _stay(state, event.time)
    state.packml, state.packml_since = PackmlState(event.state), event.time
    # On entry, not on exit: an order that arrives in Stopped must not see earlier values.
    if state.packml in _FORGET_ONCE:
        state.done_once.clear()
        forget_skips(state, lambda job: not job.progress.started)
        forget_all(state)
    if state.packml is PackmlState.STARTING:
        state.had_work = state.has_work


def clock_stepped(event: e.ClockStepped, state: CellState) -> None:
    """Give what lasts the begin that the new clock would have shown: ages stay the same."""
    by_s = event.seconds
    state.packml_since += by_s
    state.clock_set_s += by_s
    state.clock = None
    note_uptime(event, state)
    for key, task in list(state.running.items()):
        started = changed(task, started=task.started + by_s)
        state.tasks[key] = state.running[key] = started
    for name, hold in state.holds.items():
        state.holds[name] = changed(hold, since=hold.since + by_s)
    for component, out in state.out_of_service.items():
        state.out_of_service[component] = changed(out, since=out.since + by_s)
    state.stopped_by = _later(state.stopped_by, by_s)
    state.stop_after_by = _later(state.stop_after_by, by_s)


def _later(wish: Wish | None, by_s: float) -> Wish | None:
    return changed(wish, time=wish.time + by_s) if wish is not None and wish.time else wish


def note_uptime(event: Timed, state: CellState) -> Uptime | None:
    """Keep when an event was by both clocks; returns its uptime, None: not known."""
    if event.uptime is None or not state.boot:
        return None
    up = Uptime(state.boot, event.uptime)
    state.clock = ClockReading(event.time, up)
    return up


def operator_decided(event: e.OperatorDecided, state: CellState) -> None:
    """Store an operator's wish for the whole cell; other effects of a decision are events.

    A shutdown of the node is not stored: the next orchestrator continues.
    """
    about = (event.hold, event.job, event.item, event.component, event.digest)
    if any(subject is not None for subject in about):
        return
    wish = Wish(event.answer, event.who, event.reason, event.time, event.known)
    if event.answer in STAND:
        state.stopped_by = wish
    elif event.answer == START:
        state.stopped_by = None
    elif event.answer.startswith(STOP_AFTER):
        state.stop_after_by = wish  # `never` is taken back by the event that follows it


def _stay(state: CellState, until: float) -> None:
    """Add the present stay to the time spent in the PackML state."""
    state.packml_times = state.times(until)


# How events of holds change the state, and which answers a hold offers.


def hold_of(event: e.HoldRaised) -> Hold:
    """Return a hold as it is raised."""
    return Hold(id=event.hold, since=event.time, **shared(event, Hold))


def hold_raised(event: e.HoldRaised, state: CellState) -> None:
    hold = changed(hold_of(event), message_words=facts_of(event.message))
    state.holds[hold.id] = hold
    state.holds_raised += 1
    if hold.is_unseen:
        forget_all(state)  # nobody knows what was done meanwhile (5.3)
    if hold.reason == TOO_MANY_REJECTS and hold.job is not None:
        note_hold(state, hold.job, hold.id)
    if hold.key is not None:
        before = state.tasks.get(hold.key, TaskState(Phase.HELD))
        state.tasks[hold.key] = changed(before, phase=Phase.HELD, hold=hold.id)
        _offer(state, hold)


def offer_anew(state: CellState) -> None:
    """Update the offered answers of every held task to its item and its job."""
    for hold in list(state.holds.values()):
        _offer(state, hold)


def _offer(state: CellState, hold: Hold) -> None:
    """Update the offered answers of a task that failed; other holds keep theirs."""
    key = hold.key
    if key is None or state.tasks[key].reason is None:
        return
    task = state.task(key) or index_task(state.cell)
    offered = answers(state, key, task)
    state.holds[hold.id] = changed(
        hold,
        answers=offered,
        answers_together=together(hold, task, offered),
        answers_why=why_not_offered(state, key, task),
    )


def hold_released(event: e.HoldReleased, state: CellState) -> None:
    if state.holds.pop(event.hold).reason == TOO_MANY_REJECTS:
        forget_rejects(state, event.hold)
