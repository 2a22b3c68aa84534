"""Taking a cell over from its journal (semantics 9.2): not a special case, only a beginning."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from bt_orchestrator.errors import JournalMismatch
from bt_orchestrator.model import events as e
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.fold import apply
from bt_orchestrator.model.state import CellState
from bt_orchestrator.runtime.operators import RESUME

RESTARTED = 'restarted'
"""Reason of the hold with which an orchestrator waits after a restart with unfinished work."""


def replay(state: CellState, events: Sequence[e.Event]) -> None:
    """Bring the state to where the journal ends.

    :raises JournalMismatch: there is unfinished work, and the cell is not the one it was begun on
    """
    try:
        for event in events:
            apply(state, event)
    except (AssertionError, KeyError) as error:
        raise JournalMismatch(
            f'the journal does not fit cell {state.cell.name}: event {state.seq + 1} cannot have '
            f'happened there ({error!r}); name the cell file that it was written with'
        ) from error
    if state.jobs and state.cell_digest != digest(state.cell):
        raise JournalMismatch(
            f'the journal holds unfinished jobs ({", ".join(state.jobs)}) and the cell file has '
            'changed since they began; run them to their end with the file as it was'
        )


def take_over(state: CellState, *, auto_resume: bool) -> Iterator[e.Event]:
    """Note that a new orchestrator is there, and what it found.

    :param auto_resume: go on at once; otherwise start nothing until somebody resumes the cell
    """
    yield e.OrchestratorStarted(cell=state.cell.name, digest=digest(state.cell))
    for name, component in state.cell.components.items():
        if component.state is not None and state.readings[name].ready:
            yield e.ComponentStateChanged(component=name, ready=False)  # not heard of yet
    adopted = [(key, task) for key, task in state.running.items() if task.goal is not None]
    for key, task in adopted:
        assert task.goal is not None
        yield e.TaskAdopted(**key._asdict(), attempt=task.attempt, goal=task.goal)
    if state.jobs and not auto_resume and not state.pauses:
        jobs = f'{len(state.jobs)} unfinished job{"s" if len(state.jobs) > 1 else ""}'
        goals = f'{len(adopted)} goal{"s" if len(adopted) != 1 else ""} in flight'
        yield e.HoldRaised(
            hold=state.next_hold,
            reason=RESTARTED,
            message=f'{jobs}, {goals}',
            answers=(RESUME,),
        )
