"""What people ask of the cell as a whole (semantics 7.2, 7.3)."""

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
    """Start nothing more, in whatever state; what runs goes on to its end."""

    cause = Cause.HOLD


@dataclass(frozen=True)
class Resume(CellCommand):
    """Release pauses: one's own, unless it says which (semantics 7.3)."""

    cause = Cause.UNHOLD
    hold: str | None = None
    """Id of the one to release, whoever owns it."""
    everyones: bool = False
    """Release every pause, whoever owns it, but for those that must be named."""


@dataclass(frozen=True)
class Stop(CellCommand):
    """Finish the cycles in hand, then be Stopped."""

    cause = Cause.STOP


@dataclass(frozen=True)
class Abort(CellCommand):
    """Cancel every goal now; keep items, flags, steps and queue."""

    cause = Cause.ABORT


@dataclass(frozen=True, kw_only=True)
class Clear(CellCommand):
    """Say what stands on the belt after an abort; then be Stopped."""

    cause = Cause.CLEAR
    belt: Statement
