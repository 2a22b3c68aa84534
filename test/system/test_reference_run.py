"""The reference script on real ROS 2 does what its virtual-time run says."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest
from cell_processes import ROOT, CellProcesses, StartCell

from bt_orchestrator.model.codec import to_record
from bt_orchestrator.model.jobs.order import WorkOrder
from bt_orchestrator.ros.types.action_types import InstalledActionTypes
from bt_orchestrator.script.cell_file import read_cell
from bt_orchestrator.script.orders.order_file import bind_order
from bt_orchestrator.script.script_file import read_script
from bt_orchestrator.sim.simulation import Outcome, Simulation
from bt_orchestrator.store.memory import MemoryStore

pytestmark = pytest.mark.every_distro

CELL = ROOT / 'config' / 'reference_cell.yaml'
SCRIPT = ROOT / 'trees' / 'reference_process.yaml'

ITEMS = 50

Steps = dict[int, list[tuple[str, str, str]]]


def virtual_records(quantity: int, order: str) -> list[dict[str, Any]]:
    """Run the reference script in virtual time and return its records."""
    types = InstalledActionTypes()
    cell = read_cell(CELL, types)
    script = read_script(SCRIPT, cell, types)
    store = MemoryStore()
    simulation = Simulation(cell, types, store)
    job = bind_order(WorkOrder(str(SCRIPT), order, quantity), script, order)
    (answer,) = simulation.submit([job])
    assert answer.accepted
    assert simulation.run() is Outcome.FINISHED
    simulation.close()
    return [to_record(event) for event in store.read()]


def steps_by_section(records: Iterable[dict[str, Any]]) -> Steps:
    """Return what happened in each section, in order: event, item, task."""
    steps: Steps = {}
    for record in records:
        if 'section' in record:
            step = (record['event'], record.get('item', ''), record.get('task', ''))
            steps.setdefault(record['section'], []).append(step)
    return steps


@pytest.fixture
def reference_cell(start_cell: StartCell) -> CellProcesses:
    """Give the reference cell."""
    cell = start_cell(CELL.read_text(), run_options=['--trees', str(SCRIPT.parent)])
    cell.connect()
    return cell


def test_fifty_items_follow_order_of_virtual_run(
    reference_cell: CellProcesses,
) -> None:
    watch = reference_cell.watch
    watch.submit(SCRIPT, quantity=ITEMS)
    job = watch.until_ended('WO-1', within_s=90.0)

    assert (job.placed, job.processed, job.packed) == (ITEMS, ITEMS, ITEMS)
    assert (job.rejected, job.nonconforming, job.missing) == (0, 0, 0)
    watch.assert_gapless()
    virtual = steps_by_section(virtual_records(ITEMS, 'WO-1'))
    real = steps_by_section(watch.events)
    assert sorted(real) == sorted(virtual) == [1, 2, 3, 4, 5]
    for section, steps in virtual.items():
        assert real[section] == steps, f'section {section}'
    reference_cell.stop()


def test_every_recorded_goal_is_executed_once(reference_cell: CellProcesses) -> None:
    watch = reference_cell.watch
    watch.submit(SCRIPT, quantity=3, params={'label': 'A7'})
    watch.until_ended('WO-1')

    started = [event['goal'] for event in watch.seen('task.started')]
    assert len(set(started)) == len(started)
    assert sorted(started) == sorted(r['goal'] for r in reference_cell.goals(event='started'))
    assert not reference_cell.goals(event='rejected')
    labelled = watch.seen('task.started', args={'special_argument_1': 'A7'})
    assert {event['task'] for event in labelled} == {'4.2'}
    reference_cell.stop()
