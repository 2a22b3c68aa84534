"""Releasing generated scripts (semantics 6.10)."""

from __future__ import annotations

from bt_orchestrator.errors import CommandRefused
from bt_orchestrator.model import events as e
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.commands import ReleaseScript
from bt_orchestrator.model.jobs.releases import is_released
from bt_orchestrator.model.limits import listed
from bt_orchestrator.model.state import CellState
from bt_orchestrator.runtime.command_record import decided


def carry_out(command: ReleaseScript, state: CellState) -> tuple[str, list[e.Event]]:
    """Return the answer and the events.

    :raises CommandRefused: it is meant for another cell, or nothing would change
    """
    script, here = command.digest, digest(state.cell)
    if command.cell_digest not in ('', here):
        raise CommandRefused(
            f'{script} was generated for another cell file ({command.cell_digest}) than the one '
            f'that runs here ({here}); generate it with that file, and release what comes of it'
        )
    if is_released(state, script):
        raise CommandRefused(f'{script} is released for this cell already')
    reason = '' if command.by is None else str(command.by)
    released = e.ScriptReleased(digest=script, cell_digest=here, reason=reason)
    return '\n'.join(_said(script, state)), [*decided(command), released]


def _said(script: str, state: CellState) -> list[str]:
    waited = [job.job.id for job in state.queue if job.unreleased == script]
    free = f'; it was waited for by {listed(waited, "none")}' if waited else ''
    return [f'{script} is released for this cell{free}']
