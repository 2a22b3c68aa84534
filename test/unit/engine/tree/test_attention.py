"""A part that is left out of a tick looks as if it had been ticked."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from fakes.action_types import FakeActionTypes
from fakes.drawn.lines import lines
from fakes.drawn.plan import Plan
from fakes.full_tree import FullTree
from fakes.line import THREE, Line, with_section
from fakes.plan_operator import operate
from fakes.plan_runs import ProductBench, show
from fakes.profiles import examples
from fakes.virtual_run import VirtualRun
from hypothesis import given
from py_trees.common import Status

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.script import Script
from bt_orchestrator.script.cell_file import read_cell
from bt_orchestrator.script.script_file import read_script

ROOT = Path(__file__).parents[4]
Snapshot = list[tuple[str, Status, str]]

FLAGS = (
    with_section(1, '- {id: place, @a1, qty_change: 1}\n- {id: look, @b1}')
    + 'lateral_dependencies:\n  - {flag: seen, upstream: look, downstream: work, capacity: 2}\n'
)
RETRIES = with_section(2, '- {id: work, @a2, retries: 2, retry_delay: 3.0, on_failure: continue}')


def snapshot(run: VirtualRun) -> Snapshot:
    """Return what a watcher would see, without what is invalid: that keeps old words."""
    nodes = run.sim.orchestrator.tree.root.iterate()
    return [
        (node.name, node.status, node.feedback_message if node.status is Status.RUNNING else '')
        for node in nodes
    ]


def _pair(cell: Cell, script: Script) -> tuple[VirtualRun, VirtualRun]:
    runs = VirtualRun(cell, FakeActionTypes()), VirtualRun(cell, FakeActionTypes())
    orchestrator = runs[1].sim.orchestrator
    orchestrator.tree.close()
    orchestrator.tree = FullTree(orchestrator._ledger, orchestrator._projection.space)
    orchestrator._ledger._noticing.clear()
    for run in runs:
        run.submit('J', script, 4)
        run.submit('K', script, 2)
    return runs


def _compare(cell: Cell, script: Script) -> int:
    lazy, full = _pair(cell, script)
    moments = 0
    while (due := full.sim.clock.next_deadline()) is not None and full.state.jobs:
        lazy.go(due)
        full.go(due)
        assert snapshot(lazy) == snapshot(full), f'at {due} s'
        moments += 1
    assert lazy.records == full.records
    return moments


@pytest.mark.parametrize('name', ['reference_process', 'inspect_and_assemble'])
def test_shipped_scripts_match_full_ticks(name: str) -> None:
    types = FakeActionTypes()
    cell = read_cell(ROOT / 'config/reference_cell.yaml', types)
    script = read_script(ROOT / f'trees/{name}.yaml', cell, types)
    assert _compare(cell, script) > 30


@pytest.mark.parametrize(
    ('text', 'faults'), [(THREE, {}), (FLAGS, {}), (RETRIES, {'a2': 'TASK_A#2=abort #3=false'})]
)
def test_small_lines_match_full_ticks(text: str, faults: dict[str, str]) -> None:
    line = Line(faults=faults)
    assert _compare(line.cell, line.script(text)) > 10


@examples(8, 200)
@given(lines())
def test_drawn_lines_match_newly_built_trees(plan: Plan) -> None:
    """What is left out of a tick, a part or a finished step, looks as if it had been ticked."""
    show(plan)
    operate(ProductBench(plan, viewed=True), plan.moments)


IN_A_GROUP = """
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2: [{parallel: [{id: one, @a2}, {id: two, @b2}]}]
  3: [{id: pack, @a3, qty_change: -1}]
zones: {table: [one, two]}
"""
"""While `a2` is not ready, `two` takes the zone that `one` waits for as well."""

GONE_EARLY = """
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2:
    release_conveyor: after_last_conveyor_task
    tasks:
      - {id: look, @b2, on_failure: reject}
      - {id: late, @a2, requires_conveyor: false, runs_for: all}
  3: [{id: out, @a3, qty_change: -1, runs_for: rejected}]
  4: [{id: pack, @a4, qty_change: -1}]
"""
"""While `late` waits for `a2`, its item leaves the belt in section 3."""


@pytest.mark.parametrize('text', [IN_A_GROUP, GONE_EARLY])
def test_waiting_tasks_see_effects_of_others_at_once(text: str) -> None:
    line = Line(4, topics=('a2',), faults={'a2': '#0=not_ready:40', 'b2': '#1=abort'})
    run = VirtualRun(line.cell, line.types, viewed=True)
    assert run.submit('J', line.script(text), 2).accepted
    run.go(until=39.0)
    assert run.waits()
    assert run.go().ended or run.state.holds


def test_a_waiting_section_is_not_ticked() -> None:
    line = Line(sections=5)
    run = line.begin(
        'sections:\n  1: [{id: place, @a1, qty_change: 1}]\n'
        '  2: [{id: one, @a2}, {id: two, @b2}]\n  5: [{id: pack, @a5, qty_change: -1}]\n'
    )
    run.go(until=3.5)  # placed at 1 s, moved at 3 s
    ticked: list[int] = []
    for number, section in run.sim.orchestrator.tree.sections.items():
        inner = section.run

        def run_it(number: int = number, inner: Callable[[], Status] = inner) -> Status:
            ticked.append(number)
            return inner()

        section.run = run_it  # type: ignore[method-assign]
    run.go(until=4.5)  # `one` ends at 4 s and `two` begins
    assert set(ticked) == {2}
