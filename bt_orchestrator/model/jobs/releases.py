"""Releases of generated scripts, and the jobs that wait for one (semantics 6.10)."""

from __future__ import annotations

from bt_orchestrator.model.cell import Release
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.script import MadeFrom, Script
from bt_orchestrator.model.state import CellState


def awaits_release(state: CellState, script: Script) -> bool:
    """Tell whether a new job of a script has to wait until somebody has released it."""
    if script.made_from is None or state.cell.release is Release.AUTOMATIC:
        return False
    return not is_released(state, digest(script))


def is_released(state: CellState, script: str) -> bool:
    """Tell whether a script is released for this cell.

    :param script: its digest
    """
    return digest(state.cell) in state.released.get(script, ())


def released_before(state: CellState, made_from: MadeFrom, script: str) -> Script | None:
    """Return the released script that is taken in place of a new one (semantics 6.11), if any.

    :param script: digest of the new one
    """
    if state.cell.release is Release.AUTOMATIC or is_released(state, script):
        return None
    kept = reversed(state.released_scripts.items())
    return next(
        (
            one
            for name, one in kept
            if is_released(state, name) and made_from.says_the_same(one.made_from)
        ),
        None,
    )
