"""Which waits tell why a line does not go on."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

from fakes.action_types import FakeActionTypes
from fakes.shipped import REFERENCE_CELL, STUCK

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.wait import WaitKind
from bt_orchestrator.script.cell_file import read_cell
from bt_orchestrator.script.script_file import read_script
from bt_orchestrator.sim.faults import with_faults
from bt_orchestrator.sim.simulation import Outcome, Simulation, standstill
from bt_orchestrator.store.memory import MemoryStore

TYPES = FakeActionTypes()


@contextmanager
def stuck(cell: Cell) -> Iterator[Simulation]:
    simulation = Simulation(cell, TYPES, MemoryStore())
    simulation.submit([Job('WO', read_script(STUCK, cell, TYPES), 3)])
    assert simulation.run() is Outcome.STUCK
    yield simulation
    simulation.close()


def reasons(simulation: Simulation) -> list[str]:
    return [str(wait) for wait in standstill(simulation.state, simulation.waits())]


def test_idle_sections_appear_only_if_waits_name_them() -> None:
    with stuck(read_cell(REFERENCE_CELL, TYPES)) as simulation:
        parts = [wait.part for wait in simulation.waits()]

        assert reasons(simulation) == [
            'section 2: waiting for assemble to take flag read_before_assemble',
            'section 4: waiting for an item',
            'belt: waiting for section 2 to finish with WO/2',
        ]
    assert {'section 1', 'section 3', 'section 5'} < set(parts)


def test_wait_circle_is_reported_as_structured_facts() -> None:
    with stuck(read_cell(REFERENCE_CELL, TYPES)) as simulation:
        circle = [wait.wait for wait in standstill(simulation.state, simulation.waits())]

    assert [(wait.kind, wait.name, wait.sections, wait.task) for wait in circle] == [
        (WaitKind.FLAG, 'read_before_assemble', (4,), 'assemble'),
        (WaitKind.ITEM, '', (), ''),
        (WaitKind.TURN, '', (2,), ''),
    ]


def test_a_goal_that_never_ends_is_named() -> None:
    cell = with_faults(read_cell(REFERENCE_CELL, TYPES), ['component_1a=hang'], TYPES)
    camera = replace(cell.components['component_1a'], timeout_s=None)
    cell = replace(cell, components={**cell.components, 'component_1a': camera})
    with stuck(cell) as simulation:
        assert reasons(simulation)[-1] == (
            'component_1a: inspect of WO/1 runs since 3 s and will never end'
        )


def test_an_index_move_that_never_ends_is_named() -> None:
    cell = with_faults(read_cell(REFERENCE_CELL, TYPES), ['conveyor=hang'], TYPES)
    belt = replace(cell.conveyor.component, timeout_s=None)
    components = {**cell.components, 'conveyor': belt}
    cell = replace(cell, conveyor=replace(cell.conveyor, component=belt), components=components)
    with stuck(cell) as simulation:
        assert 'conveyor: index runs since 1 s and will never end' in reasons(simulation)
