"""How events of holds change the state, and which answers a hold offers."""

from __future__ import annotations

from bt_orchestrator.model import events as e
from bt_orchestrator.model.alike import together
from bt_orchestrator.model.failures import answers, why_not_offered
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
