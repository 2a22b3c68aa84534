"""The state of a cell as one message (bt_orchestrator_interfaces/msg/Status)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from bt_orchestrator_interfaces.msg import (
    ComponentStatus,
    FlagStatus,
    HoldStatus,
    PassedTask,
    SectionStatus,
    StateTime,
    Status,
    TaskStatus,
)

from bt_orchestrator.model.cell import Component
from bt_orchestrator.model.codec import json_of
from bt_orchestrator.model.contest import Contest
from bt_orchestrator.model.events import TaskKey
from bt_orchestrator.model.limits import FEEDBACK_BYTES, QUEUE_SHOWN, rough_size, shortened
from bt_orchestrator.model.packml import VERBS, Cause, possible_in
from bt_orchestrator.model.state import CellState, Cycle, Phase, SectionState, TaskState
from bt_orchestrator.model.wish import way_to_work
from bt_orchestrator.ros.services.job_message import job_messages, passed_task
from bt_orchestrator.ros.stamps import to_time
from bt_orchestrator.runtime.orchestrator import Orchestrator
from bt_orchestrator.tree.reasons import waiting

ENDED_SHOWN = 10
"""How many ended jobs the status still lists, the last ones."""


def status_message(orchestrator: Orchestrator, now: float, ends: Mapping[str, float]) -> Status:
    """Build the whole message.

    :param ends: in how many seconds jobs are expected to end
    """
    state, tree = orchestrator.state, orchestrator.tree
    jobs = (*state.jobs.first(QUEUE_SHOWN), *list(state.ended.values())[-ENDED_SHOWN:])
    return Status(
        stamp=to_time(now),
        seq=state.seq,
        history=state.history,
        cell=state.cell.name,
        state=state.packml.value,
        stop_after=state.stop_after or '',
        **_wish(state),
        journal_failure=orchestrator.broken or '',
        state_since=to_time(state.packml_since),
        state_times=[StateTime(state=m.value, seconds=s) for m, s in state.times(now).items()],
        stop_reason=state.stop_reason.value if state.stop_reason else '',
        stop_message=state.stop_message,
        commands=[VERBS[cause] for cause in _possible(orchestrator)],
        belt_moving=state.indexing,
        belt_waiting=waiting(tree.belt),
        initialization_waiting=waiting(tree.initialization),
        sections=[_section(orchestrator, section) for section in state.sections.values()],
        components=[_component(orchestrator, c) for c in state.cell.components.values()],
        jobs=job_messages(state, jobs, ends),
        queued=state.jobs.waiting,
        flags=[
            FlagStatus(name=name, count=flag.count, capacity=flag.capacity)
            for name, flag in state.flags.items()
        ],
        holds=_holds(state),
    )


def _possible(orchestrator: Orchestrator) -> tuple[Cause, ...]:
    """Return what the cell may be told; without a journal only to cancel its goals."""
    return (Cause.ABORT,) if orchestrator.broken else possible_in(orchestrator.state.packml)


def _wish(state: CellState) -> dict[str, Any]:
    wish = state.wish
    if wish is None:
        return {}
    return {
        'stopped_by': wish.who,
        'stopped_with': wish.command,
        'stopped_why': wish.reason,
        'stopped_at': to_time(wish.time),
        'waits_for': way_to_work(state.packml) if state.stopped_by is not None else '',
    }


def _section(orchestrator: Orchestrator, section: SectionState) -> SectionStatus:
    state = orchestrator.state
    slot = state.slot(section.number)
    cycle = section.cycle
    item = state.items[cycle.item] if cycle else None
    passed, failed = _passed(state, section.number, cycle)
    return SectionStatus(
        section=section.number,
        slot=section.slot or '',
        slot_empty_position=slot is not None and not slot.present,
        slot_rejected=slot is not None and slot.rejected,
        slot_nonconforming=list(slot.nonconforming) if slot else [],
        job=cycle.job if cycle else '',
        item=cycle.item if cycle else '',
        item_empty_position=item is not None and not item.present,
        item_rejected=item is not None and item.rejected,
        item_nonconforming=list(item.nonconforming) if item else [],
        running=[
            _task(orchestrator, key, task)
            for key, task in state.running.items()
            if key.section == section.number
        ],
        done=[task.id for task in passed],
        passed=passed,
        failed=failed,
        waiting=waiting(orchestrator.tree.sections[section.number]),
    )


def _passed(
    state: CellState, section: int, cycle: Cycle | None
) -> tuple[list[PassedTask], list[str]]:
    """Return which tasks the cycle in hand has passed, and which failed."""
    if cycle is None:
        return [], []
    nonconforming = state.items[cycle.item].nonconforming
    passed, failed = [], []
    for task in state.script(cycle.job).sections[section].tasks:
        progress = state.tasks.get(TaskKey(cycle.job, section, cycle.item, task.id))
        if progress is None:
            continue
        if progress.phase is Phase.DONE:
            is_nonconforming = task.id in nonconforming
            passed.append(passed_task(task.id, progress, is_nonconforming=is_nonconforming))
        has_failed = progress.end is not None and progress.end.is_failure
        if has_failed or task.id in nonconforming or progress.phase in _FAILED:
            failed.append(task.id)
    return passed, failed


_FAILED = (Phase.FAILED, Phase.RETRYING, Phase.HELD)


def _task(orchestrator: Orchestrator, key: TaskKey, progress: TaskState) -> TaskStatus:
    task = orchestrator.state.task(key)
    conveyor = orchestrator.state.cell.conveyor
    return TaskStatus(
        id=key.task,
        name=task.name if task else conveyor.task,
        action=task.action if task else conveyor.component.action,
        attempt=progress.attempt,
        goal=progress.goal or '',
        started=to_time(progress.started),
        feedback=_feedback(orchestrator, progress.goal),
    )


def _component(orchestrator: Orchestrator, component: Component) -> ComponentStatus:
    state = orchestrator.state
    key = state.reserved.get(component.name)
    progress = state.tasks.get(key) if key else None
    reading = state.readings[component.name]
    contested = contested_words(orchestrator, component)
    return ComponentStatus(
        name=component.name,
        action=component.action,
        available=orchestrator.gateway.available(component.name),
        ready=reading.ready and not contested,
        contested=contested,
        state='' if reading.value is None else str(reading.value),
        task=str(key) if key else '',
        feedback=_feedback(orchestrator, progress.goal if progress else None),
    )


def contested_words(orchestrator: Orchestrator, component: Component) -> str:
    """Say who else has a part in a component; also while nothing is recorded any more."""
    seen = Contest(tuple(orchestrator.gateway.rivals(component.name)))
    contest = seen or orchestrator.state.contests.get(component.name, seen)
    return contest.words(component.action)


def _feedback(orchestrator: Orchestrator, goal: str | None) -> str:
    flight = orchestrator.flights.goal(goal) if goal else None
    feedback = flight.feedback if flight else None
    if feedback is None:
        return ''
    if rough_size(feedback) > FEEDBACK_BYTES:
        most = FEEDBACK_BYTES // max(1, len(feedback))
        feedback = {name: shortened(value, most) for name, value in feedback.items()}
    return json_of(feedback)


def _holds(state: CellState) -> list[HoldStatus]:
    return [
        HoldStatus(
            id=hold.id,
            job=hold.job or '',
            section=hold.section or 0,
            item=hold.item or '',
            task=hold.task or '',
            name=hold.name,
            component=hold.component,
            action=hold.action,
            attempt=hold.attempt,
            attempts=hold.attempts,
            reason=hold.reason,
            message=hold.message,
            answers=list(hold.answers),
            owner=hold.owner,
            since=to_time(hold.since),
        )
        for hold in state.holds.values()
    ]
