"""The status of a section: its slot, its current cycle, and what it finished in this beat."""

from __future__ import annotations

from bt_orchestrator.engine.runtime.tasks_in_flight import TasksInFlight
from bt_orchestrator.model.passed import passed_tasks
from bt_orchestrator.model.state import CellState, Finished, ItemState, SectionState
from bt_orchestrator.model.status import FinishedCycle, ItemStatus, SectionStatus
from bt_orchestrator.model.wait import Wait


def section_status(
    state: CellState, section: SectionState, in_flight: TasksInFlight, waits: tuple[Wait, ...]
) -> SectionStatus:
    """Return the status of a section.

    :param waits: why it waits
    """
    slot, cycle = state.slot(section.number), section.cycle
    finished = section.finished if state.belt_carries else None
    passed, failed = passed_tasks(state, section.number, cycle) if cycle else ((), ())
    return SectionStatus(
        number=section.number,
        slot=None if slot is None else _item(slot),
        job=cycle.job if cycle else '',
        item=_item(state.items[cycle.item]) if cycle else None,
        running=in_flight.of_section(section.number),
        passed=passed,
        failed=failed,
        waits=waits,
        finished=_finished(finished) if finished else None,
    )


def _item(item: ItemState) -> ItemStatus:
    return ItemStatus(item.id, item.present, item.rejected, tuple(item.nonconforming))


def _finished(finished: Finished) -> FinishedCycle:
    return FinishedCycle(finished.job, finished.item, finished.passed, finished.failed)
