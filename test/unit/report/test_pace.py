"""The estimate of when jobs end, against runs in virtual time."""

from __future__ import annotations

import pytest
from fakes.line import THREE, Line, with_section
from fakes.virtual_run import VirtualRun

from bt_orchestrator.report.pace import expected_ends_s, item_s

AHEAD = with_section(
    1, '[{id: pick, @b1, requires_conveyor: false}, {id: place, @a1, qty_change: 1}]'
)
GROUP = with_section(2, '[{parallel: [{id: work, @a2}, [{id: x, @b2}, {id: y, @b2.TASK_B}]]}]')
RELEASE = with_section(
    2,
    """
      release_conveyor: after_last_conveyor_task
      tasks: [{id: work, @a2}, {id: clean, @b2, requires_conveyor: false}]
    """,
)


@pytest.mark.parametrize('text', [THREE, AHEAD, GROUP, RELEASE])
@pytest.mark.parametrize('slow', ['a1', 'b1', 'a2', 'b2', 'a3'])
def test_the_pace_is_that_of_a_run(text: str, slow: str) -> None:
    line = Line(seconds={slow: 7.0})
    run = line.run(text, 8)
    packed = run.times('item.removed')
    assert item_s(line.script(text), line.cell) == packed[3] - packed[2]


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


def test_what_a_paused_job_or_a_stop_keeps_back_has_no_end() -> None:
    line = Line()
    run = line.begin(quantity=5)
    run.submit('K', line.script(THREE))
    run.control('pause', 'J')
    assert expected_ends_s(run.state, line.cell) == {}
