"""Commands to the cell as a whole (semantics 7.2, 7.3)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from bt_orchestrator.model.belt_statement import Statement
from bt_orchestrator.model.by import By
from bt_orchestrator.model.packml import Cause


@dataclass(frozen=True)
class CellCommand:
    """Base of the commands."""

    cause: ClassVar[Cause]
    by: By


@dataclass(frozen=True)
class Reset(CellCommand):
    """Get ready to start."""

    cause = Cause.RESET


@dataclass(frozen=True)
class Start(CellCommand):
    """Begin to work."""

    cause = Cause.START


@dataclass(frozen=True)
class Pause(CellCommand):
    """Start nothing more, in any state; running goals continue to their end."""

    cause = Cause.HOLD


@dataclass(frozen=True)
class Resume(CellCommand):
    """Release pauses: by default the sender's own (semantics 7.3)."""

    cause = Cause.UNHOLD
    hold: str | None = None
    """Id of the pause to release, of any owner."""
    everyones: bool = False
    """Release every pause of any owner, except those that must be named."""


@dataclass(frozen=True)
class Stop(CellCommand):
    """Finish the cycles in progress, then enter Stopped."""

    cause = Cause.STOP


@dataclass(frozen=True)
class Abort(CellCommand):
    """Cancel every goal now; keep items, flags, steps and queue."""

    cause = Cause.ABORT


@dataclass(frozen=True, kw_only=True)
class Clear(CellCommand):
    """Confirm what is on the belt after an abort; then enter Stopped."""

    cause = Cause.CLEAR
    belt: Statement
