"""Taking components out of service, and bringing them back (semantics 7.5)."""

from __future__ import annotations

from collections.abc import Iterator

from bt_orchestrator.base.errors import CommandRefused
from bt_orchestrator.engine.runtime.deciding import Decided, decides
from bt_orchestrator.model import events as e
from bt_orchestrator.model.jobs.needs import needed_by, on_the_line_words, still_needed
from bt_orchestrator.model.limits import listed
from bt_orchestrator.model.requests import IN_SERVICE, OUT_OF_SERVICE, Asked
from bt_orchestrator.model.state import CellState, OutOfService
from bt_orchestrator.model.words import joined, sentence


def without_component(state: CellState) -> Iterator[e.ComponentInService]:
    """Yield the end of every record about a component that the cell file no longer has."""
    for name in list(state.out_of_service):
        if name not in state.cell.components:
            yield e.ComponentInService(component=name)


@decides(OUT_OF_SERVICE)
def _take_out(state: CellState, asked: Asked, _: float) -> Decided:
    name = asked['component']
    before = _present(name, state)
    if before is not None:
        raise CommandRefused(sentence('out_already', component=name, words=before.reason))
    jobs = tuple(_queued_with(name, state))
    event = e.ComponentOutOfService(component=name, reason=str(asked.by), jobs=jobs)
    return '\n'.join(_of_taking_out(state, name, jobs)), [event]


@decides(IN_SERVICE)
def _bring_back(state: CellState, asked: Asked, _: float) -> Decided:
    name = asked['component']
    if _present(name, state) is None:
        others = listed(state.out_of_service, 'none')
        raise CommandRefused(sentence('in_service', component=name, components=others))
    return sentence('now_in_service', component=name), [e.ComponentInService(component=name)]


def _present(name: str, state: CellState) -> OutOfService | None:
    if name not in state.cell.components:
        known = listed(state.cell.components, 'none')
        there = sentence('cell_has', components=known)
        raise CommandRefused(joined(sentence('no_component', component=name), there))
    return state.out_of_service.get(name)


def _queued_with(component: str, state: CellState) -> Iterator[str]:
    """Yield the jobs of the queue that need a component."""
    needs: dict[str, bool] = {}
    for job in state.queue:
        if job.digest not in needs:
            needs[job.digest] = component in needed_by(job.job.script, state.cell)
        if needs[job.digest] and not job.ending:
            yield job.job.id


def _of_taking_out(state: CellState, component: str, passed: tuple[str, ...]) -> Iterator[str]:
    yield sentence('now_out', component=component)
    task = state.reserved.get(component)
    if task in state.running:
        yield sentence('runs_on', task=task)
    if passed:
        by_recipe = [job for job in passed if state.jobs[job].job.recipe is not None]
        yield sentence('passed', jobs=listed(passed, 'none'))
        if by_recipe:
            yield sentence('passed_by_recipe', jobs=listed(by_recipe, 'none'))
    for job in state.on_the_line:
        if component in still_needed(state, job):
            is_by_recipe, to_begin = job.job.recipe is not None, job.cycles_left
            yield on_the_line_words(
                job.job.id, (component,), is_by_recipe=is_by_recipe, to_begin=to_begin
            )
