"""The Gantt chart of a run: what is on it, and where."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
from fakes.action_types import FakeActionTypes
from fakes.shipped import REFERENCE_CELL, TREES

from bt_orchestrator.model.events import TaskKey
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.wait import WaitKind
from bt_orchestrator.script.cell_file import read_cell
from bt_orchestrator.script.script_file import read_script
from bt_orchestrator.sim.faults import with_faults
from bt_orchestrator.sim.simulation import Simulation
from bt_orchestrator.store.memory import MemoryStore
from bt_orchestrator.view.drawing.gantt import Gantt, GanttFold, HoldBar, Row, TaskBar
from bt_orchestrator.view.drawing.gantt_page import gantt_svg, ticks, time_label
from bt_orchestrator.view.drawing.gantt_style import WAITS, fitting
from bt_orchestrator.view.report.wait_log import WaitLog

TYPES = FakeActionTypes()
SVG = '{http://www.w3.org/2000/svg}'


def chart(*jobs: tuple[str, str, int], faults: tuple[str, ...] = ()) -> Gantt:
    cell = with_faults(read_cell(REFERENCE_CELL, TYPES), faults, TYPES)
    fold, log = GanttFold(), WaitLog()
    simulation = Simulation(cell, TYPES, MemoryStore(), [fold])
    for name, script, quantity in jobs:
        read = read_script(TREES / f'{script}.yaml', cell, TYPES)
        values = {key: parameter.default for key, parameter in read.params.items()}
        simulation.submit([Job(name, read, quantity, values)])
    simulation.run(lambda: log.look(simulation.state, simulation.waits(), simulation.clock.now()))
    now = simulation.clock.now()
    gantt = fold.chart(cell.name, cell.conveyor.sections, log.end(now), now)
    simulation.close()
    return gantt


def bars(svg: str, row: str, kind: str) -> list[ET.Element]:
    group = next(g for g in ET.fromstring(svg).iter(f'{SVG}g') if g.get('id') == row)
    return [r for r in group.iter(f'{SVG}rect') if kind in (r.get('class') or '').split()]


def words(svg: str) -> list[str]:
    return [text.text or '' for text in ET.fromstring(svg).iter(f'{SVG}text')]


def title(bar: ET.Element) -> str:
    element = bar.find(f'{SVG}title')
    assert element is not None
    return element.text or ''


def test_rows_show_tasks_moves_and_waits_of_cell() -> None:
    svg = gantt_svg(chart(('WO', 'reference_process', 3)))

    counts = {row: len(bars(svg, row, 'work')) for row in ('initialization', 'section_4')}
    assert counts == {'initialization': 3, 'section_4': 12}
    assert len(bars(svg, 'belt', 'move')) == 6
    assert title(bars(svg, 'section_2', 'work')[0]).splitlines() == [
        '2.1 of WO/1: TASK_A at component_1a',
        '7.5 to 10.5 s, 3 s',
    ]
    assert any('turn of section 4' in title(bar) for bar in bars(svg, 'belt', 'wait'))


def test_lanes_separate_parallel_tasks_without_overlap() -> None:
    gantt = chart(('WO', 'inspect_and_assemble', 4))
    by_title = {row.title: row for row in gantt.rows}

    assert len(by_title['section 4'].lanes()) == 2
    for row in gantt.rows:
        for lane in row.lanes():
            ends = [bar.end_s for bar in lane]
            assert all(bar.start_s >= end for bar, end in zip(lane[1:], ends, strict=False))
        work = [(bar.start_s, bar.end_s) for bar in row.tasks]
        for wait in row.waits:
            assert not any(start < wait.end_s and wait.start_s < end for start, end in work)


def test_every_item_can_be_read_of_twenty() -> None:
    texts = words(gantt_svg(chart(('WO-20', 'reference_process', 20))))

    for number in range(3, 21):
        assert texts.count(f'WO-20/{number}') == 5


def test_two_jobs_differ_in_name_and_colour() -> None:
    svg = gantt_svg(chart(('WO-1', 'reference_process', 3), ('WO-2', 'inspect_and_assemble', 3)))
    fills = {title(b).split('\n')[0].split(': ')[0].split(' of ')[1][:4]: b.get('fill')
             for b in bars(svg, 'section_1', 'work')}  # fmt: skip

    assert fills['WO-1'] != fills['WO-2']
    assert {'WO-1/3', 'WO-2/3'} <= set(words(svg))
    assert {'task of WO-1 (items A.1 …)', 'task of WO-2 (items B.1 …)'} <= set(words(svg))


def test_failed_attempts_and_holds_are_marked() -> None:
    svg = gantt_svg(chart(('WO', 'reference_process', 3), faults=('component_3a.#2=abort',)))

    (failed,) = bars(svg, 'section_4', 'failed')
    (hold,) = bars(svg, 'section_4', 'hold')
    assert title(failed).endswith('aborted')
    assert title(hold).startswith('hold 1: section 4, 4.1 (TASK_A) of WO/2 at component_3a')
    assert {'hold', 'attempt that failed', 'waits for an answer to a hold'} <= set(words(svg))


def test_one_run_is_always_drawn_the_same() -> None:
    assert len({gantt_svg(chart(('WO', 'inspect_and_assemble', 3))) for _ in range(2)}) == 1


def test_what_a_user_writes_cannot_break_the_drawing() -> None:
    bar = TaskBar(TaskKey('<&"', 1, '<&"/1', 'a<b'), 'N', 'c', '', 0.0, 5.0, 'succeeded')
    svg = gantt_svg(Gantt('<cell>', 5.0, ('<&"',), (Row('section 1', [bar]),)))

    assert title(bars(svg, 'section_1', 'work')[0]).startswith('a<b of <&"/1')


def test_what_xml_cannot_carry_breaks_no_drawing() -> None:
    hold = HoldBar('1', 'aborted (\x1b[31m \x00 \ud800)', 0.0, 5.0)
    svg = gantt_svg(Gantt('cell', 5.0, ('WO',), (Row('section 1', holds=[hold]),)))

    assert 'aborted (\ufffd[31m \ufffd \ufffd)' in title(bars(svg, 'section_1', 'hold')[0])
    assert svg.encode()


def test_every_kind_of_wait_has_a_look() -> None:
    assert set(WAITS) == set(WaitKind)
    patterns = [path for _, path in WAITS.values()]
    assert len(set(patterns)) == len(patterns)


@pytest.mark.parametrize(
    ('total_s', 'step', 'last'),
    [(39.0, '5 s', '35 s'), (150.0, '10 s', '150 s'), (7200.0, '10:00', '2:00:00')],
)
def test_ticks_stand_at_round_times(total_s: float, step: str, last: str) -> None:
    marks = ticks(total_s, 1200.0)
    labels = [time_label(mark, marks[1]) for mark in marks]

    assert (labels[1], labels[-1]) == (step, last)
    assert 1200.0 / (len(marks) - 1) >= 60.0


def test_nothing_has_a_chart_too(tmp_path: Path) -> None:
    assert gantt_svg(Gantt('cell', 0.0, (), (Row('belt'),))).startswith('<?xml')


@pytest.mark.parametrize(('room', 'text'), [(100.0, 'assemble'), (30.0, 'asse…'), (12.0, '')])
def test_a_text_is_shortened_before_it_runs_over(room: float, text: str) -> None:
    assert fitting('assemble', 'task', room) == text


def test_shared_arm_has_one_row_by_component() -> None:
    cell = read_cell(REFERENCE_CELL, TYPES)
    fold, log = GanttFold(by_component=True), WaitLog()
    simulation = Simulation(cell, TYPES, MemoryStore(), [fold])
    script = read_script(TREES / 'reference_process.yaml', cell, TYPES)
    values = {key: parameter.default for key, parameter in script.params.items()}
    simulation.submit([Job('WO', script, 2, values)])
    simulation.run(lambda: log.look(simulation.state, simulation.waits(), simulation.clock.now()))
    now = simulation.clock.now()
    gantt = fold.chart(cell.name, 5, log.end(now), now, list(cell.components))
    simulation.close()
    assert [row.title for row in gantt.rows] == list(cell.components)
    svg = gantt_svg(gantt)
    assert [title(bar).split(':')[0] for bar in bars(svg, 'component_3b', 'work')] == [
        '4.2 of WO/1',
        '4.3 of WO/1',
        '4.2 of WO/2',
        '4.3 of WO/2',
    ]
    assert bars(svg, 'component_1a', 'wait')
    assert '1: 2.1' in words(svg)
