"""Taking jobs into the queue, or refusing them with the reason."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from bt_orchestrator.errors import CommandRefused
from bt_orchestrator.model import events as e
from bt_orchestrator.model.by import By
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.order import Job
from bt_orchestrator.model.script import Dependency, Script
from bt_orchestrator.model.state import CellState
from bt_orchestrator.proof.deadlock import get_stuck_together
from bt_orchestrator.runtime.command_record import decided_to_add

FITS = 'fits, but was not queued because of the others'
"""What is said of the good orders among some that were refused together."""


def queue(
    state: CellState,
    jobs: Sequence[Job],
    *,
    position: int | None = None,
    held: bool = False,
    by: By | None = None,
) -> list[e.Event]:
    """Queue jobs, all or none.

    :param position: place of the first, from 1; None: the end
    :raises CommandRefused: an id was used, or flags contradict those of a live job
    """
    _refuse_unless_all_fit(state, jobs)
    events: list[e.Event] = []
    loaded = set(state.scripts)
    for number, job in enumerate(jobs):
        events += decided_to_add(job.id, by)
        events += _loaded(job.script, loaded)
        events.append(_queued(job, None if position is None else position + number, held=held))
    return events


def change(state: CellState, job: Job) -> list[e.Event]:
    """Let a queued job be another one.

    :raises CommandRefused: its flags contradict those of another live job
    """
    others = (live.job.script for name, live in state.jobs.items() if name != job.id)
    why = _contradiction(job.script, others)
    if why is not None:
        raise CommandRefused(why)
    updated = e.JobUpdated(
        job=job.id,
        script=job.script.name,
        digest=digest(job.script),
        quantity=job.quantity,
        params=job.params,
    )
    return [*_loaded(job.script, set(state.scripts)), updated]


def _queued(job: Job, position: int | None, *, held: bool) -> e.JobQueued:
    return e.JobQueued(
        job=job.id,
        script=job.script.name,
        digest=digest(job.script),
        quantity=job.quantity,
        params=job.params,
        position=position,
        held=held,
    )


def _loaded(script: Script, known: set[str]) -> Iterator[e.ScriptLoaded]:
    name = digest(script)
    if name not in known:
        known.add(name)
        yield e.ScriptLoaded(script=script.name, digest=name, definition=script)


def _refuse_unless_all_fit(state: CellState, jobs: Sequence[Job]) -> None:
    reasons = list(_reasons(state, jobs))
    wrong = [reason for reason in reasons if reason is not None]
    if wrong:
        each = [
            f'{job.id} {FITS}' if r is None else r for job, r in zip(jobs, reasons, strict=True)
        ]
        raise CommandRefused('; '.join(wrong), each)


def _reasons(state: CellState, jobs: Sequence[Job]) -> Iterator[str | None]:
    """Yield for each job why it does not fit to those that live and those given before it."""
    ids: set[str] = set()
    scripts = [live.job.script for live in state.jobs.values()]
    for job in jobs:
        if job.id in ids or job.id in state.order_ids:
            yield f'order {job.id} was given before; choose another id'
        else:
            yield _contradiction(job.script, scripts)
        ids.add(job.id)
        scripts.append(job.script)


def _contradiction(new: Script, known: Iterable[Script]) -> str | None:
    """Say why a script cannot share its flags with those of other jobs (semantics 4.1)."""
    others = list({id(script): script for script in known}.values())
    return _disagreement(new, others) or _circle(new, others)


def _circle(new: Script, known: Sequence[Script]) -> str | None:
    """Say with which scripts a line could get stuck, although with none of them alone."""
    flags = {dependency.flag for dependency in new.dependencies}
    sharing = [s for s in known if not flags.isdisjoint(d.flag for d in s.dependencies)]
    if not sharing or not get_stuck_together([new, *(s for s in known if s != new)]):
        return None
    names = ', '.join(dict.fromkeys(script.name for script in sharing))
    return (
        f'script {new.name} shares flags with {names}, and where jobs of both follow each other '
        f'the line can get stuck, although with each alone it cannot; use other flags, or wait '
        f'until no job of {names} is left'
    )


def _disagreement(new: Script, known: Iterable[Script]) -> str | None:
    """Say which script shares a flag and disagrees about it."""
    for script in known:
        there = {dependency.flag: dependency for dependency in script.dependencies}
        for dependency in new.dependencies:
            other = there.get(dependency.flag)
            if other is not None and _traits(new, dependency) != _traits(script, other):
                return (
                    f'script {new.name} and script {script.name} share the flag '
                    f'{dependency.flag} but disagree on its capacity, its initial count or the '
                    'sections of its tasks; make them agree or use two names'
                )
    return None


def _traits(script: Script, dependency: Dependency) -> tuple[int, int, int, int]:
    upstream = script.section_of(dependency.upstream)
    downstream = script.section_of(dependency.downstream)
    return dependency.capacity, dependency.initial, upstream, downstream
