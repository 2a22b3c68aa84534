"""How the events of the cell as a whole change the state; part of `model.fold`."""

from __future__ import annotations

from bt_orchestrator.model import events as e
from bt_orchestrator.model.packml import Mode
from bt_orchestrator.model.state import CellState
from bt_orchestrator.model.stop_reason import StopReason

_FORGET_ONCE = (Mode.STOPPED, Mode.ABORTED)
"""States in which somebody may have moved anything by hand (semantics 5.1)."""

_ORDERED_TO_STAND = (Mode.STOPPING, Mode.STOPPED, Mode.ABORTING, Mode.ABORTED)


def orchestrator_started(event: e.OrchestratorStarted, state: CellState) -> None:
    """Go on where the last one ended; the time without one counts for no state."""
    if state.seq:
        _stay(state, state.time)
    state.mode_since = event.time
    state.cell_digest = event.digest
    state.shutting_down = False


def orchestrator_stopping(_: e.OrchestratorStopping, state: CellState) -> None:
    """Let nothing start."""
    state.shutting_down = True


def stop_reason_changed(event: e.StopReasonChanged, state: CellState) -> None:
    """Stand still for another reason, or for none."""
    state.stop_reason = StopReason(event.stop_reason) if event.stop_reason else None
    state.stop_message = event.reason


def cell_state_changed(event: e.CellStateChanged, state: CellState) -> None:
    """Enter another PackML state."""
    _stay(state, event.time)
    state.mode, state.mode_since = Mode(event.state), event.time
    # Not when it is left: an order that arrives in Stopped must not see what was before.
    if state.mode in _FORGET_ONCE:
        state.done_once.clear()
    if state.mode is Mode.STARTING:
        state.order_arrived = state.has_work
    # A shutdown is nobody's wish that the cell stands: the next orchestrator goes on.
    elif state.mode in _ORDERED_TO_STAND and not state.shutting_down:
        state.order_arrived = False


def _stay(state: CellState, until: float) -> None:
    """Add the present stay to the time spent in the mode."""
    state.mode_times = state.times(until)
