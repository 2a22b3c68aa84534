"""The fold: which function changes the state by which event. Nothing else changes it."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from bt_orchestrator.model import events as e
from bt_orchestrator.model.folds import cell_folds as cell
from bt_orchestrator.model.folds import line, tasks
from bt_orchestrator.model.jobs import job_folds as jobs
from bt_orchestrator.model.state import CellState

ON_THE_BELT = {
    e.ItemPlaced,
    e.ItemMissing,
    e.ItemMoved,
    e.ItemRemoved,
    e.PositionEnded,
    e.BeltIndexStarted,
    e.BeltIndexed,
}
"""Events that change the content of the belt."""

CHANGE_ANSWERS = {
    e.ItemRejected,
    e.ItemMissing,
    e.ItemRemoved,
    e.PositionEnded,
    e.JobAborting,
    e.JobStopping,
}
"""Events that may change the answers that holds offer."""


def apply(state: CellState, event: e.Event) -> None:
    """Change the state by one event.

    :raises AssertionError: the event cannot have happened in this state
    """
    kind, seq = type(event), event.seq
    assert seq == state.seq + 1, f'event {seq} after {state.seq}'
    fold = _FOLDS.get(kind)
    assert fold is not None, f'no fold for {kind.__name__} at event {state.seq}'
    fold(event, state)
    state.seq, state.time = seq, event.time
    if kind in ON_THE_BELT:
        state.belt_seq = seq
    if state.holds and kind in CHANGE_ANSWERS:
        cell.offer_anew(state)


def _refused(_: e.Event, state: CellState) -> None:
    """Change nothing."""


_FOLDS: Mapping[type[e.Event], Callable[..., None]] = {
    # jobs
    e.ScriptLoaded: jobs.script_loaded,
    e.JobQueued: jobs.job_queued,
    e.JobMoved: jobs.job_moved,
    e.QueueArranged: jobs.queue_arranged,
    e.JobUpdated: jobs.job_updated,
    e.ScriptReleased: jobs.script_released,
    e.JobHeld: jobs.job_held,
    e.JobReleased: jobs.job_released,
    e.JobMayStart: jobs.job_may_start,
    e.JobRemoved: jobs.job_removed,
    e.QueueStopRequested: jobs.queue_stop_requested,
    e.QueueStopCancelled: jobs.queue_stop_cancelled,
    e.QueueStopReached: jobs.queue_stop_reached,
    e.JobStarted: jobs.job_started,
    e.JobPaused: jobs.job_paused,
    e.JobResumed: jobs.job_resumed,
    e.JobStopping: jobs.job_stopping,
    e.JobAborting: jobs.job_aborting,
    e.JobCompleted: jobs.job_ended,
    e.JobAborted: jobs.job_ended,
    e.JobCleared: jobs.job_cleared,
    # tasks
    e.TaskStarted: tasks.task_started,
    e.TaskAdopted: tasks.task_adopted,
    e.TaskResent: tasks.task_resent,
    e.TaskCancelRequested: tasks.task_cancel_requested,
    e.TaskFailed: tasks.task_failed,
    e.TaskRetrying: tasks.task_retrying,
    e.TaskSucceeded: tasks.task_succeeded,
    e.TaskMarkedDone: tasks.task_marked_done,
    e.TaskSkipped: tasks.task_skipped,
    e.TaskContinued: tasks.task_continued,
    # cycles, flags, the belt
    e.CycleStarted: line.cycle_started,
    e.TurnCompleted: line.turn_completed,
    e.CycleCompleted: line.cycle_completed,
    e.RoundBegun: tasks.round_begun,
    e.FlagRaised: line.flag_changed,
    e.FlagLowered: line.flag_changed,
    e.BeatStarted: line.beat_started,
    e.BeltIndexStarted: line.belt_index_started,
    e.BeltIndexed: line.belt_indexed,
    # items
    e.ItemPlaced: line.item_placed,
    e.ItemMissing: line.item_missing,
    e.ItemIdentified: line.item_identified,
    e.ItemMoved: line.item_moved,
    e.ItemRejected: line.item_rejected,
    e.ItemNonconforming: line.item_nonconforming,
    e.ItemRemoved: line.item_removed,
    e.PositionEnded: line.position_ended,
    # components, holds
    e.ComponentStateChanged: cell.component_state_changed,
    e.ComponentContested: cell.component_contested,
    e.ComponentOutOfService: cell.component_out_of_service,
    e.ComponentInService: cell.component_in_service,
    e.ComponentSetupLost: cell.component_setup_lost,
    e.ComponentSetupRead: cell.component_setup_read,
    e.HoldRaised: cell.hold_raised,
    e.HoldReleased: cell.hold_released,
    # the cell
    e.OperatorDecided: cell.operator_decided,
    e.OrchestratorStarted: cell.orchestrator_started,
    e.OrchestratorStopping: cell.orchestrator_stopping,
    e.StopReasonChanged: cell.stop_reason_changed,
    e.CellStateChanged: cell.cell_state_changed,
    e.ControlChanged: cell.control_changed,
    e.UnitModeChanged: cell.unit_mode_changed,
    e.ManualAsked: tasks.manual_asked,
    e.RequestSigned: cell.request_signed,
    e.SafetyChanged: cell.safety_changed,
    e.ClockStepped: cell.clock_stepped,
    e.OperatorRefused: _refused,
    e.RequestRefused: _refused,
}
