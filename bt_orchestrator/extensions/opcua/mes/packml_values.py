"""The values of a cell in PackML's Status and Admin, as far as they are known."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from bt_orchestrator.extensions.opcua.mes.packml import STATE_NUMBERS
from bt_orchestrator.extensions.opcua.mes.stop_ids import NONE, StopId, deciding_hold, id_of_stop
from bt_orchestrator.model.packml import TRANSITIONS, Cause, PackmlState
from bt_orchestrator.model.status import CellStatus
from bt_orchestrator.model.stop_reason import StopReason


@dataclass(frozen=True)
class Stop:
    """Why the line stands still: PackML's StopReason."""

    reason: StopId = NONE
    hold: int = 0
    """Number of the hold that decides it; 0: none does."""
    message: str = ''
    since: float | None = None
    """Seconds since the epoch; None: it does not stand still."""


@dataclass(frozen=True)
class PackmlValues:
    """One status in PackML's words; times are whole seconds, by state number."""

    state: int
    is_changing: bool
    """It is in an acting state, which ends by itself."""
    in_state_s: Mapping[int, int]
    """Of the present stay."""
    total_s: Mapping[int, int]
    """Since the beginning of the journal."""
    stop: Stop
    is_starved: bool
    is_blocked: bool


def packml_values(status: CellStatus) -> PackmlValues:
    """Return a status in PackML's words."""
    number = STATE_NUMBERS[status.state]
    return PackmlValues(
        state=number,
        is_changing=status.state is not PackmlState.EXECUTE
        and Cause.DONE in TRANSITIONS[status.state],
        in_state_s={number: max(0, int(status.stamp - status.state_since))},
        total_s={STATE_NUMBERS[state]: int(s) for state, s in status.state_times.items()},
        stop=_stop(status),
        is_starved=status.stop_reason is StopReason.STARVED,
        is_blocked=status.stop_reason is StopReason.BLOCKED,
    )


def _stop(status: CellStatus) -> Stop:
    reason = id_of_stop(status)
    if reason is NONE:
        return Stop()
    hold = deciding_hold(status)
    message = status.journal_failure or status.stop_message
    if hold is None or status.journal_failure:
        return Stop(reason, 0, message, status.state_since)
    return Stop(reason, int(hold.id), message, hold.since)
