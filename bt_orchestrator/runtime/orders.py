"""Taking jobs into the queue, or refusing them with the reason."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from bt_orchestrator.errors import CommandRefused
from bt_orchestrator.model import events as e
from bt_orchestrator.model.by import By
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.jobs.job_commands import Sharing
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.script import Script
from bt_orchestrator.model.state import CellState
from bt_orchestrator.proof.sharing import contradiction
from bt_orchestrator.runtime.command_record import decided_to_add

FITS = 'fits, but was not queued because of the others'
"""The message for a valid order that was refused together with others."""


def queue(
    state: CellState,
    jobs: Sequence[Job],
    *,
    position: int | None = None,
    held: bool = False,
    by: By | None = None,
    sharing: Sharing | None = None,
) -> list[e.Event]:
    """Queue jobs, all or none.

    :param position: place of the first, from 1; None: the end
    :param sharing: known result of the check of their scripts against the live ones
    :raises CommandRefused: an id was used, or flags contradict those of a live job
    """
    _refuse_unless_all_fit(state, jobs, sharing)
    events: list[e.Event] = []
    loaded = set(state.scripts)
    for number, job in enumerate(jobs):
        events += decided_to_add(job.id, by)
        events += _loaded(job.script, loaded)
        events.append(_queued(job, None if position is None else position + number, held=held))
    return events


def change(state: CellState, job: Job, sharing: Sharing | None = None) -> list[e.Event]:
    """Replace the order of a queued job.

    :raises CommandRefused: its flags contradict those of another live job
    """
    own = state.jobs[job.id].digest
    is_shared = state.jobs.users(own) > 1
    others = {name: one for name, one in state.scripts.items() if name != own or is_shared}
    why = contradiction(job.script, others, sharing)
    if why is not None:
        raise CommandRefused(why)
    updated = e.JobUpdated(**_ordered(job))
    return [*_loaded(job.script, set(state.scripts)), updated]


def _queued(job: Job, position: int | None, *, held: bool) -> e.JobQueued:
    return e.JobQueued(**_ordered(job), position=position, held=held)


def _ordered(job: Job) -> dict[str, Any]:
    """Return the fields of an order in an event."""
    return {
        'job': job.id,
        'script': job.script.name,
        'digest': digest(job.script),
        'quantity': job.quantity,
        'params': job.params,
        **vars(job.terms),
    }


def _loaded(script: Script, known: set[str]) -> Iterator[e.ScriptLoaded]:
    name = digest(script)
    if name not in known:
        known.add(name)
        yield e.ScriptLoaded(script=script.name, digest=name, definition=script)


def _refuse_unless_all_fit(state: CellState, jobs: Sequence[Job], sharing: Sharing | None) -> None:
    reasons = list(_reasons(state, jobs, sharing))
    wrong = [reason for reason in reasons if reason is not None]
    if wrong:
        each = [
            f'{job.id} {FITS}' if r is None else r for job, r in zip(jobs, reasons, strict=True)
        ]
        raise CommandRefused('; '.join(wrong), each)


def _reasons(
    state: CellState, jobs: Sequence[Job], sharing: Sharing | None
) -> Iterator[str | None]:
    """Yield for each job why it does not fit the live jobs and the given jobs before it."""
    ids: set[str] = set()
    known = dict(state.scripts)
    why_not: dict[str, str | None] = {}
    for job in jobs:
        script = digest(job.script)
        if job.id in ids or job.id in state.order_ids:
            yield f'order {job.id} was given before; choose another id'
        else:
            if script not in why_not:
                why_not[script] = contradiction(job.script, known, sharing)
            yield why_not[script]
        ids.add(job.id)
        known[script] = job.script
