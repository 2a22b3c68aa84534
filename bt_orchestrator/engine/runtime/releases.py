"""Releasing generated scripts (semantics 6.10)."""

from __future__ import annotations

from bt_orchestrator.base.errors import CommandRefused
from bt_orchestrator.engine.runtime.deciding import Decided, decides
from bt_orchestrator.model import events as e
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.jobs.needs import is_released
from bt_orchestrator.model.limits import listed
from bt_orchestrator.model.requests import RELEASE_SCRIPT, Asked
from bt_orchestrator.model.state import CellState


@decides(RELEASE_SCRIPT)
def _release(state: CellState, asked: Asked, _: float) -> Decided:
    script, here, meant = asked['script'], digest(state.cell), asked.arguments.get('cell_digest')
    if meant and meant != here:
        raise CommandRefused(
            f'{script} was generated for another cell file ({meant}) than the one '
            f'that runs here ({here}); generate it with that file, and release what comes of it'
        )
    if is_released(state, script):
        raise CommandRefused(f'{script} is released for this cell already')
    reason = '' if asked.by is None else str(asked.by)
    released = e.ScriptReleased(digest=script, cell_digest=here, reason=reason)
    return '\n'.join(_said(script, state)), [released]


def _said(script: str, state: CellState) -> list[str]:
    waited = [job.job.id for job in state.queue if job.unreleased == script]
    free = f'; it was waited for by {listed(waited, "none")}' if waited else ''
    return [f'{script} is released for this cell{free}']
