"""What becomes of the cell and its jobs by itself: ends, PackML states (semantics 6.1, 7.2)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict

from bt_orchestrator.model import events as e
from bt_orchestrator.model.line import is_complete
from bt_orchestrator.model.packml import Mode
from bt_orchestrator.model.state import CellState, Phase


def jobs_ended(state: CellState) -> Iterator[e.JobCompleted | e.JobAborted]:
    """Yield the end of every job of which nothing remains."""
    for name, job in list(state.jobs.items()):
        if is_complete(state, job):
            kind = e.JobAborted if job.aborting else e.JobCompleted
            yield kind(
                job=name,
                exit_status=job.exit_status,
                reason=job.end_reason,
                counts=asdict(job.progress),
            )


def next_mode(
    state: CellState, now: float, *, quiet: bool, auto_start: bool
) -> e.CellStateChanged | None:
    """Return the transition that is due.

    :param quiet: the tree decided nothing in its last tick
    :param auto_start: the cell resets and starts by itself when there is a job
    """
    due = _due(state, now, quiet=quiet, auto_start=auto_start)
    if due is None:
        return None
    mode, reason = due
    return e.CellStateChanged(state=mode.value, previous=state.mode.value, reason=reason)


def _due(
    state: CellState, now: float, *, quiet: bool, auto_start: bool
) -> tuple[Mode, str] | None:
    mode = state.mode
    if mode is Mode.STOPPED:
        return (Mode.RESETTING, 'an order arrived') if auto_start and state.order_arrived else None
    if mode is Mode.COMPLETE:
        return (Mode.RESETTING, 'an order arrived') if auto_start and state.has_work else None
    if mode is Mode.IDLE:
        return (Mode.STARTING, 'an order arrived') if auto_start and state.has_work else None
    if mode is Mode.EXECUTE:
        return _out_of_execute(state)
    if mode in (Mode.HOLDING, Mode.HELD) and not state.holds:
        return Mode.UNHOLDING, 'every hold is answered'
    if mode is Mode.HOLDING:
        still = quiet and not state.running and not _will_retry(state, now)
        return (Mode.HELD, 'nothing runs and nothing can start') if still else None
    if mode is Mode.STOPPING:
        return (Mode.STOPPED, 'every goal ended') if not state.running else None
    return _PASSING.get(mode)


_PASSING = {
    Mode.RESETTING: (Mode.IDLE, ''),
    Mode.STARTING: (Mode.EXECUTE, ''),
    Mode.UNHOLDING: (Mode.EXECUTE, ''),
    Mode.COMPLETING: (Mode.COMPLETE, ''),
}
"""States with nothing to do in them yet."""


def _out_of_execute(state: CellState) -> tuple[Mode, str] | None:
    if state.holds:
        hold = next(iter(state.holds.values()))
        return Mode.HOLDING, f'hold {hold.id}: {hold.task or hold.item}, {hold.reason}'
    return None if state.has_work else (Mode.COMPLETING, 'every job ended')


def _will_retry(state: CellState, now: float) -> bool:
    return any(
        task.phase is Phase.RETRYING and task.not_before > now for task in state.tasks.values()
    )
