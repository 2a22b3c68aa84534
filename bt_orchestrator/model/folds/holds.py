"""How events of holds change the state, and which answers a hold offers."""

from __future__ import annotations

from bt_orchestrator.model import events as e
from bt_orchestrator.model.failures import answers
from bt_orchestrator.model.frozen import changed
from bt_orchestrator.model.script import index_task
from bt_orchestrator.model.state import CellState, Hold, Phase, TaskState


def hold_raised(event: e.HoldRaised, state: CellState) -> None:
    hold = Hold(
        id=event.hold,
        job=event.job,
        section=event.section,
        item=event.item,
        task=event.task,
        reason=event.reason,
        message=event.message,
        answers=event.answers,
        since=event.time,
        owner=event.owner,
        name=event.name,
        component=event.component,
        action=event.action,
        attempt=event.attempt,
        attempts=event.attempts,
        round=event.round,
        controller_said=event.controller_said,
        last_feedback=event.last_feedback,
        topic_says=event.topic_says,
    )
    state.holds[hold.id] = hold
    state.holds_raised += 1
    if hold.key is not None:
        before = state.tasks.get(hold.key, TaskState(Phase.HELD))
        state.tasks[hold.key] = changed(before, phase=Phase.HELD, hold=hold.id)


def offer_anew(state: CellState) -> None:
    """Update the offered answers of every held task to its item and its job."""
    for name, hold in state.holds.items():
        key = hold.key
        if key is not None and state.tasks[key].reason is not None:
            task = state.task(key) or index_task(state.cell)
            state.holds[name] = changed(hold, answers=answers(state, key, task))


def hold_released(event: e.HoldReleased, state: CellState) -> None:
    del state.holds[event.hold]
