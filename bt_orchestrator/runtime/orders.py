"""Taking a job into the queue, or refusing it with the reason."""

from __future__ import annotations

from collections.abc import Iterator

from bt_orchestrator.errors import CommandRefused
from bt_orchestrator.model import events as e
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.commands import SubmitJob
from bt_orchestrator.model.script import Dependency, Script
from bt_orchestrator.model.state import CellState


def submit(state: CellState, command: SubmitJob) -> Iterator[e.Event]:
    """Queue a job.

    :raises CommandRefused: its id was used, or its flags contradict those of a live job
    """
    job = command.job
    if job.id in state.jobs or job.id in state.ended:
        raise CommandRefused(f'order {job.id} was given before; choose another id')
    for live in state.jobs.values():
        _check_flags(job.script, live.job.script)
    name = digest(job.script)
    if name not in state.scripts:
        yield e.ScriptLoaded(script=job.script.name, digest=name, definition=job.script)
    yield e.JobQueued(
        job=job.id,
        script=job.script.name,
        digest=name,
        quantity=job.quantity,
        params=job.params,
    )


def _check_flags(new: Script, known: Script) -> None:
    """Refuse scripts that share a flag and disagree about it (semantics 4.1)."""
    there = {dependency.flag: dependency for dependency in known.dependencies}
    for dependency in new.dependencies:
        other = there.get(dependency.flag)
        if other is not None and _traits(new, dependency) != _traits(known, other):
            raise CommandRefused(
                f'script {new.name} and script {known.name} share the flag {dependency.flag} '
                'but disagree on its capacity, its initial count or the sections of its tasks; '
                'make them agree or use two names'
            )


def _traits(script: Script, dependency: Dependency) -> tuple[int, int, int, int]:
    upstream = script.section_of(dependency.upstream)
    downstream = script.section_of(dependency.downstream)
    return dependency.capacity, dependency.initial, upstream, downstream
