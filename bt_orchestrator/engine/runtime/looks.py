"""Holds that ask an operator to check the line (semantics 7.3)."""

from __future__ import annotations

from datetime import datetime, timezone

from bt_orchestrator.engine.runtime.cell_commands import RESUME
from bt_orchestrator.model import events as e
from bt_orchestrator.model.state import CellState


def to_be_named(state: CellState, reason: str, message: str) -> e.HoldRaised:
    """Return a hold of the whole cell that is released only by its name.

    :param reason: one of `model.pauses.NAMED`
    :param message: what the operator has to check
    """
    return e.HoldRaised(hold=state.next_hold, reason=reason, message=message, answers=(RESUME,))


def in_utc(seconds: float) -> str:
    """Write a time of the wall clock."""
    moment = datetime.fromtimestamp(seconds, timezone.utc)
    return f'{moment:%Y-%m-%d %H:%M:%S} UTC'
