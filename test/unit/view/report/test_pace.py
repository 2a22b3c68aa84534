"""The estimate of when jobs end, against runs in virtual time."""

from __future__ import annotations

from dataclasses import replace

import pytest
from fakes.line import THREE, Line, with_section
from fakes.virtual_run import VirtualRun

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.view.report.pace import Paces, expected_ends_s


def test_the_queue_ends_one_job_after_the_other() -> None:
    line = Line()
    script = line.script(THREE)
    run = VirtualRun(line.cell, line.types)
    for name in 'JKL':
        run.submit(name, script, 5)
    run.control('hold', 'L')
    run.go(until=8.0)
    ends = expected_ends_s(run.state, line.cell)
    run.go()
    real = {r['job']: r['time'] - 8.0 for r in run.all('job.completed')}
    assert ends.keys() == {'J', 'K'}
    assert ends == {name: pytest.approx(end, abs=4.0) for name, end in real.items()}


def test_flag_waits_are_in_the_estimate() -> None:
    """With capacity 1 section 2 begins to work when section 3 has packed: 62 s an item, not 32."""
    line = Line(seconds={'a2': 30.0, 'a3': 30.0})
    text = f'{THREE}lateral_dependencies: [{{flag: turned, upstream: work, downstream: pack}}]\n'
    run = line.begin(text, 10)
    run.go(until=100.0)
    ends = expected_ends_s(run.state, line.cell)
    run.go()
    (end,) = (r['time'] - 100.0 for r in run.all('job.completed'))
    assert ends == {'J': pytest.approx(end, abs=2 * 62.0)}


def test_jobs_behind_pause_have_no_expected_end() -> None:
    line = Line()
    run = line.begin(quantity=5)
    run.submit('K', line.script(THREE))
    run.control('pause', 'J')
    assert expected_ends_s(run.state, line.cell) == {}


def test_job_needing_unavailable_component_has_no_end() -> None:
    """In the queue others pass it; on the line what is behind it waits as well."""
    line = Line()
    run = line.begin(quantity=5)
    other = line.script(THREE.replace('@a2', '@b2'), 'other')
    run.submit('K', line.script(THREE))
    run.submit('L', other)
    assert run.service('b2', out=True).accepted
    assert expected_ends_s(run.state, line.cell).keys() == {'J', 'K'}
    assert run.service('a2', out=True).accepted
    assert expected_ends_s(run.state, line.cell) == {}


STUCK = """
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2: [{id: work, @a2}]
  3: [{id: pack, @a3, qty_change: -1}]
lateral_dependencies:
  - {flag: backward, upstream: pack, downstream: work}
"""


def test_stuck_job_and_followers_have_no_end() -> None:
    """No submit lets it in, but a journal may be older than that."""
    line = Line()
    run = VirtualRun(line.cell, line.types)
    run.submit('J', line.script(THREE), 2)
    run.submit('K', line.script(STUCK), 2)
    run.submit('L', line.script(THREE), 2)
    assert expected_ends_s(run.state, line.cell).keys() == {'J'}


def slower(cell: Cell, name: str) -> Cell:
    component = replace(cell.components[name], durations_s={'TASK_A': 20.0})
    return replace(cell, components={**cell.components, name: component})


def test_pace_is_recomputed_when_task_durations_change(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    worked_out: list[int] = []

    def counted(nodes: int, arcs: object) -> list[object]:
        worked_out.append(nodes)
        return []

    monkeypatch.setattr('bt_orchestrator.model.proof.pace.slowest_circle', counted)
    line = Line()
    run = line.begin(quantity=5)
    run.submit('K', line.script(with_section(2, '[{id: other, @b2}]')), 5)
    paces = Paces()
    counts = []
    for cell in (line.cell, line.cell, slower(line.cell, 'lamp'), slower(line.cell, 'a2')):
        expected_ends_s(run.state, cell, paces)
        counts.append(len(worked_out))
    assert counts == [2, 2, 2, 3]
