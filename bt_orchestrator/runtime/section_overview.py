"""The status of a section: its slot, its current cycle, and the finished tasks of that."""

from __future__ import annotations

from bt_orchestrator.model.events import TaskKey
from bt_orchestrator.model.hold_words import why_words
from bt_orchestrator.model.state import (
    CellState,
    Cycle,
    End,
    ItemState,
    Phase,
    SectionState,
    TaskState,
)
from bt_orchestrator.model.status import ItemStatus, PassedTask, SectionStatus
from bt_orchestrator.model.wait import Wait
from bt_orchestrator.runtime.tasks_in_flight import TasksInFlight

_FAILED = (Phase.FAILED, Phase.RETRYING, Phase.HELD)


def section_status(
    state: CellState, section: SectionState, in_flight: TasksInFlight, waits: tuple[Wait, ...]
) -> SectionStatus:
    """Return the status of a section.

    :param waits: why it waits
    """
    slot, cycle = state.slot(section.number), section.cycle
    passed, failed = _passed(state, section.number, cycle)
    return SectionStatus(
        number=section.number,
        slot=None if slot is None else _item(slot),
        job=cycle.job if cycle else '',
        item=_item(state.items[cycle.item]) if cycle else None,
        running=in_flight.of_section(section.number),
        passed=passed,
        failed=failed,
        waits=waits,
    )


def _item(item: ItemState) -> ItemStatus:
    return ItemStatus(item.id, item.present, item.rejected, tuple(item.nonconforming))


def _passed(
    state: CellState, section: int, cycle: Cycle | None
) -> tuple[tuple[PassedTask, ...], tuple[str, ...]]:
    """Return the tasks that the current cycle has passed, and those that failed."""
    if cycle is None:
        return (), ()
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
    return tuple(passed), tuple(failed)


def passed_task(task: str, progress: TaskState, *, is_nonconforming: bool = False) -> PassedTask:
    """Return how a task in phase DONE ended.

    :param is_nonconforming: it made its item so; a state of an older version does not say it
    """
    end = progress.end or (End.CONTINUED if is_nonconforming else End.DONE)
    return PassedTask(task, end, _reason(progress))


def _reason(progress: TaskState) -> str:
    if progress.reason is None:
        return progress.message
    return why_words(progress.reason.value, progress.message)
