"""The needs of jobs: components in service (semantics 7.5), releases of scripts (6.10)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from bt_orchestrator.model.cell import Cell, Release
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.events import TaskKey
from bt_orchestrator.model.frozen import changed
from bt_orchestrator.model.line import is_done_with
from bt_orchestrator.model.script import MadeFrom, Script
from bt_orchestrator.model.state import CellState, JobState, Phase
from bt_orchestrator.model.words import joined, sentence


def needed_by(script: Script, cell: Cell) -> frozenset[str]:
    """Return the components that a job of a script needs; every job needs the conveyor."""
    tasks = script.tasks.values()
    return frozenset({cell.conveyor.component.name, *(task.component for task in tasks)})


def unavailable_to(state: CellState, script: Script) -> tuple[str, ...]:
    """Return the components out of service that a queued job of a script needs."""
    if not state.out_of_service:
        return ()
    needed = needed_by(script, state.cell)
    return tuple(name for name in state.out_of_service if name in needed)


def awaited_by(state: CellState, job: JobState) -> tuple[str, ...]:
    """Return the components out of service that a job needs; on the line what it still needs."""
    if not state.out_of_service or job.ended_at is not None:
        return ()
    if not job.started:
        return job.unavailable
    needed = still_needed(state, job)
    return tuple(name for name in state.out_of_service if name in needed)


def still_needed(state: CellState, job: JobState) -> frozenset[str]:
    """Return the components that a job on the line still needs."""
    return frozenset(_still_needed(state, job))


def awaited_when_stopped(state: CellState, job: JobState) -> tuple[str, ...]:
    """Return the components out of service that the items of a job on the line still need."""
    items = any(not item.gone for item in job.items.values())
    return awaited_by(state, changed(job, stopping=True)) if items else ()


def needs_words(job: str, unavailable: Sequence[str]) -> str:
    """Say that a job needs what is out of service."""
    kind = 'job_needs' if len(unavailable) == 1 else 'job_needs_several'
    return sentence(kind, job=job, names=' and '.join(unavailable))


def on_the_line_words(
    job: str, unavailable: Sequence[str], *, is_by_recipe: bool, to_begin: int
) -> str:
    """Say that a job on the line needs what is out of service, and what can be done.

    :param to_begin: how many items it will still begin
    """
    what = 'items_go_on'
    if to_begin:
        what = 'requeue_rest' if is_by_recipe else 'stop_and_queue'
    needs = sentence('line_needs', job=job, components=' and '.join(unavailable))
    return joined(needs, sentence(what, job=job))


def items_wait_words(job: str, unavailable: Sequence[str]) -> str:
    """Say that a job that begins no more items still waits for what is out of service."""
    needs = sentence('items_need', components=' and '.join(unavailable))
    return joined(needs, sentence('items_go_on', job=job))


def _still_needed(state: CellState, job: JobState) -> Iterator[str]:
    """Yield the components of the parts that a job on the line has not passed yet."""
    name, script = job.job.id, job.job.script
    items = [item for item in job.items.values() if not item.gone]
    if job.cycles_left or any(item.section < script.sink for item in items):
        yield state.cell.conveyor.component.name
    for task in script.initialization:
        if state.phase(TaskKey(name, None, None, task.id)) is not Phase.DONE:
            yield task.component
    for number, listed in script.sections.items():
        if not is_done_with(state, state.sections[number], job):
            yield from (task.component for task in listed.tasks)


# Releases of generated scripts, and the jobs that wait for one (semantics 6.10).


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
            candidate
            for name, candidate in kept
            if is_released(state, name) and made_from.says_the_same(candidate.made_from)
        ),
        None,
    )
