"""How events of holds change the state, and which answers a hold offers."""

from __future__ import annotations

from dataclasses import fields

from bt_orchestrator.model import events as e
from bt_orchestrator.model.failures import answers, why_not_offered
from bt_orchestrator.model.frozen import changed
from bt_orchestrator.model.jobs.setups import forget_all
from bt_orchestrator.model.requests.alike import together
from bt_orchestrator.model.script import index_task
from bt_orchestrator.model.state import CellState, Hold, Phase, TaskState
from bt_orchestrator.model.words import facts_of

_SHARED = {field.name for field in fields(Hold)} & {field.name for field in fields(e.HoldRaised)}
"""Facts of a hold that its event tells by the same name."""


def hold_of(event: e.HoldRaised) -> Hold:
    """Return a hold as it is raised."""
    return Hold(id=event.hold, since=event.time, **{name: vars(event)[name] for name in _SHARED})


def hold_raised(event: e.HoldRaised, state: CellState) -> None:
    hold = changed(hold_of(event), message_words=facts_of(event.message))
    state.holds[hold.id] = hold
    state.holds_raised += 1
    if hold.must_be_named:
        forget_all(state)  # nobody knows what was done meanwhile (5.3)
    if hold.key is not None:
        before = state.tasks.get(hold.key, TaskState(Phase.HELD))
        state.tasks[hold.key] = changed(before, phase=Phase.HELD, hold=hold.id)
        _offer(state, hold)


def offer_anew(state: CellState) -> None:
    """Update the offered answers of every held task to its item and its job."""
    for hold in list(state.holds.values()):
        _offer(state, hold)


def _offer(state: CellState, hold: Hold) -> None:
    """Update the offered answers of a task that failed; other holds keep theirs."""
    key = hold.key
    if key is None or state.tasks[key].reason is None:
        return
    task = state.task(key) or index_task(state.cell)
    offered = answers(state, key, task)
    state.holds[hold.id] = changed(
        hold,
        answers=offered,
        answers_together=together(hold, task, offered),
        answers_why=why_not_offered(state, key, task),
    )


def hold_released(event: e.HoldReleased, state: CellState) -> None:
    del state.holds[event.hold]
