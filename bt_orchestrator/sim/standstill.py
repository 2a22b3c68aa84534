"""Why a virtual run does not go on: the waits that matter, and the goals that never end."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from bt_orchestrator.model.state import CellState
from bt_orchestrator.model.wait import PartWait, Wait, WaitKind


def standstill(state: CellState, waits: Sequence[PartWait]) -> list[PartWait]:
    """Return the waits, in the order of the belt.

    A section without work that only waits for the line is left out, unless a part with work waits
    for it.
    """
    awaited = {n for wait in waits if _has_work(state, wait) for n in wait.wait.sections}
    relevant = [wait for wait in waits if _has_work(state, wait) or wait.section in awaited]
    return [*relevant, *_endless(state)]


def _has_work(state: CellState, wait: PartWait) -> bool:
    return wait.section is None or state.sections[wait.section].cycle is not None


def _endless(state: CellState) -> Iterator[PartWait]:
    """Name the goals in flight: when time stands still, nothing will end them."""
    for key, task in state.running.items():
        found = state.task(key)
        component = state.cell.conveyor.component.name if found is None else found.component
        what = f'{key} runs since {task.started:g} s and will never end'
        yield PartWait(component, Wait(what, WaitKind.COMPONENT, component, task=key.task))
