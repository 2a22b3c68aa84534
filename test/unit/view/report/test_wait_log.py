"""Where the time of a virtual run goes."""

from __future__ import annotations

import random

import pytest
from fakes.action_types import FakeActionTypes
from fakes.line import Line
from fakes.shipped import REFERENCE_CELL, TREES

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.script import Script
from bt_orchestrator.model.wait import Wait, WaitKind
from bt_orchestrator.script.cell_file import read_cell
from bt_orchestrator.script.script_file import read_script
from bt_orchestrator.sim.simulation import Simulation
from bt_orchestrator.store.memory import MemoryStore
from bt_orchestrator.view.report.forecast import Forecast, SectionLoad
from bt_orchestrator.view.report.forecast_fold import ForecastFold
from bt_orchestrator.view.report.wait_log import WaitLog, cause_of

TYPES = FakeActionTypes()


def forecast_of(cell: Cell, script: Script, quantity: int) -> Forecast:
    fold, log = ForecastFold(), WaitLog()
    simulation = Simulation(cell, TYPES, MemoryStore(), [fold])
    values = {name: parameter.default for name, parameter in script.params.items()}
    simulation.submit([Job('J', script, quantity, values)])
    simulation.run(lambda: log.look(simulation.state, simulation.waits(), simulation.clock.now()))
    result = fold.forecast(cell, log.end(simulation.clock.now()))
    simulation.close()
    return result


def waited(load: SectionLoad) -> dict[str, float]:
    return {wait.cause: wait.waited_s for wait in load.waits}


@pytest.mark.parametrize('name', ['reference_process', 'inspect_and_assemble'])
@pytest.mark.parametrize('quantity', [1, 4, 9])
def test_section_time_is_fully_work_or_wait(name: str, quantity: int) -> None:
    cell = read_cell(REFERENCE_CELL, TYPES)
    result = forecast_of(cell, read_script(TREES / f'{name}.yaml', cell, TYPES), quantity)

    for load in result.sections:
        assert load.busy_s + sum(w.waited_s for w in load.waits) == pytest.approx(result.total_s)
        assert load.utilisation + sum(w.share for w in load.waits) == pytest.approx(1.0)
    for component in result.components:
        assert component.utilisation + sum(w.share for w in component.waits) <= 1.0 + 1e-9


LATE = """
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2: [{id: slow, @a2}]
  3: [{id: work, @a3, requires_conveyor: false}, {id: pack, @a3, qty_change: -1}]
lateral_dependencies:
  - {flag: clear, upstream: slow, downstream: work}
"""


def test_waits_have_hand_computed_lengths() -> None:
    line = Line(3, seconds={'a2': 5.0})
    result = forecast_of(line.cell, line.script(LATE), 1)
    place, slow, pack = result.sections

    assert result.total_s == 11.0  # place 1, move 2, slow 5, move 2 with work beside it, pack 1
    assert (place.busy_s, slow.busy_s, pack.busy_s) == (1.0, 5.0, 2.0)
    assert waited(place) == {'an item': 6.0, 'the belt, which moves': 4.0}
    assert waited(slow) == {'an item': 2.0, 'the belt, which moves': 4.0}
    assert waited(pack) == {'an item': 6.0, 'the belt, which moves': 3.0}


FLAG = """
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2: [{id: early, @b2}]
  3: [{id: work, @b3}, {id: late, @a3}, {id: pack, @a3, qty_change: -1}]
lateral_dependencies:
  - {flag: clear, upstream: work, downstream: early, initial: 1}
"""


def test_flag_and_turn_waits_name_their_cause() -> None:
    line = Line(3, seconds={'b3': 5.0})
    result = forecast_of(line.cell, line.script(FLAG), 3)

    assert (
        waited(result.sections[1])['flag clear'] == 10.0
    )  # of items 2 and 3, work of the one before
    (b2,) = [load for load in result.components if load.component == 'b2']
    assert {wait.cause: wait.waited_s for wait in b2.waits}['flag clear'] == 10.0
    assert waited(result.sections[0])['the belt: turns of sections 2 and 3'] == 5.0
    assert {wait.kind for wait in result.components[0].waits} == {'turn'}


def test_bottleneck_alone_sets_pace_without_flags() -> None:
    drawn = random.Random(5)
    for _ in range(5):
        seconds = {f'a{n}': drawn.choice([0.5, 1.0, 2.5, 4.0, 7.5]) for n in range(1, 5)}
        line = Line(4, seconds=seconds)
        text = """
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2: [{id: t2, @a2}]
  3: [{id: t3, @a3}]
  4: [{id: pack, @a4, qty_change: -1}]
"""
        result = forecast_of(line.cell, line.script(text), 12)

        assert result.bottleneck is not None
        assert result.per_item_s == pytest.approx(result.bottleneck.pace_s)
        assert seconds[f'a{result.bottleneck.section}'] == max(seconds.values())


@pytest.mark.parametrize(
    ('wait', 'belt', 'text'),
    [
        (Wait('', WaitKind.BELT), [Wait('', WaitKind.TURN, sections=(5,))], 'turn of section 5'),
        (Wait('', WaitKind.BELT), [], 'the belt, which moves'),
        (Wait('', WaitKind.TURN, sections=(1, 2, 4)), [], 'the turns of sections 1, 2 and 4'),
        (Wait('', WaitKind.JOB, 'WO-1', sections=(3,)), [], 'section 3 to finish WO-1'),
        (Wait('', WaitKind.JOB), [], 'a job'),
        (Wait('', WaitKind.FLAG, 'clear'), [], 'flag clear'),
    ],
)
def test_wait_causes_omit_current_item(wait: Wait, belt: list[Wait], text: str) -> None:
    assert cause_of(wait, belt).text.removeprefix('the belt: ') == text


def test_every_kind_of_wait_has_words() -> None:
    for kind in WaitKind:
        assert cause_of(Wait('', kind, 'x', sections=(1,)), ()).text
