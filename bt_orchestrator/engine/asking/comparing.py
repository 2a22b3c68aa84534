"""The differences between a script that was generated again and the one of the job."""

from __future__ import annotations

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.jobs.made_anew import MadeAnew
from bt_orchestrator.model.jobs.needs import needed_by
from bt_orchestrator.model.proof.pace import pace
from bt_orchestrator.model.script import Script
from bt_orchestrator.model.state import CellState, JobState


def made_anew(job: JobState, now: Script, state: CellState) -> MadeAnew:
    """Return which components make the difference, and the pace."""
    cell, before = state.cell, job.anew
    needed = needed_by(job.job.script, cell)
    lacked = before.without if before is not None else ()
    without = tuple(one for one in state.out_of_service if one in needed or one in lacked)
    back = () if without else tuple(sorted(needed_by(now, cell) - needed))
    # What the job lacks already was not in its last pace.
    known_s = before.before_s if before is not None and before.without else 0.0
    return MadeAnew(
        without, back, _per_item_s(now, cell), known_s or _per_item_s(job.job.script, cell)
    )


def _per_item_s(script: Script, cell: Cell) -> float:
    """Return seconds from one item to the next; 0: not known."""
    found = pace(script, cell)
    return 0.0 if found is None else found.per_item_s
