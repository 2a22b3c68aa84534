"""Why a virtual run does not go on: the waits that matter, and the goals that never end."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from bt_orchestrator.model.state import CellState
from bt_orchestrator.runtime.waits import Wait

_WORD = re.compile(r'[\w.-]+')


def standstill(state: CellState, waits: Sequence[Wait]) -> list[Wait]:
    """Return who waits for whom, in the order of the belt.

    A section without work that is only waiting for the line is left out, unless another wait
    names it or one of its tasks.
    """
    kept = [wait for wait in waits if _has_work(state, wait.part)]
    words = {word for wait in kept for word in _WORD.findall(wait.reason)}
    named = ' '.join(wait.reason for wait in kept)
    idle = [
        wait
        for wait in waits
        if wait not in kept
        and (_names(named, wait.part) or words & _tasks(state, _section(wait.part)))
    ]
    relevant = [wait for wait in waits if wait in kept or wait in idle]
    return [*relevant, *_endless(state)]


def _has_work(state: CellState, part: str) -> bool:
    section = _section(part)
    return section is None or state.sections[section].cycle is not None


def _section(part: str) -> int | None:
    word, _, number = part.partition(' ')
    return int(number) if word == 'section' else None


def _names(reasons: str, part: str) -> bool:
    return re.search(rf'\b{part}\b', reasons) is not None


def _tasks(state: CellState, section: int | None) -> set[str]:
    """Return the ids of all tasks of a section, whatever the job."""
    if section is None:
        return set()
    lists = (script.sections.get(section) for script in state.scripts.values())
    return {task.id for tasks in lists if tasks is not None for task in tasks.tasks}


def _endless(state: CellState) -> Iterator[Wait]:
    """Name the goals in flight: when time stands still, nothing will end them."""
    for key, task in state.running.items():
        found = state.task(key)
        component = state.cell.conveyor.component.name if found is None else found.component
        yield Wait(component, f'{key} runs since {task.started:g} s and will never end')
