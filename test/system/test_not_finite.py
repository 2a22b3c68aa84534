"""A controller whose result is no number: kept, read by others, and sent to no controller."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from bt_orchestrator_interfaces.action import Component
from cell_processes import STATELESS_CELL, CellProcesses, StartCell, run_verb
from thread_servers import ThreadServers

SCRIPT = """
script: small
sections:
  1:
    - {id: feed, task: TASK_A, action: feeder/task, qty_change: 1}
  2:
    - {id: measure, task: TASK_B, action: worker/task}
    - {id: use, task: TASK_A, action: worker/task,
       args: {special_argument_2: "${results.measure.measurement}"}}
    - {id: pack, task: TASK_A, action: packer/task, qty_change: -1}
"""


@pytest.fixture
def got() -> list[float]:
    """Return the arguments that the worker was given."""
    return []


@pytest.fixture
def worker(got: list[float]) -> Iterator[ThreadServers]:
    def execute(goal: Any) -> Component.Result:
        if goal.request.task == Component.Goal.TASK_A:
            got.append(goal.request.special_argument_2)
        goal.succeed()
        return Component.Result(task_result=True, measurement=math.nan)

    servers = ThreadServers()
    servers.serve('worker/task', Component, execute)
    yield servers
    servers.close()


def test_non_finite_result_reaches_no_other_controller(
    worker: ThreadServers, got: list[float], start_cell: StartCell, tmp_path: Path
) -> None:
    path = tmp_path / 'journal.sqlite3'
    options = ['--journal', str(path), '--auto-resume']
    cell: CellProcesses = start_cell(
        STATELESS_CELL, shares=['feeder,packer,conveyor'], run_options=options
    )
    cell.connect()
    cell.watch.submit(cell.script(SCRIPT), quantity=1)
    held = cell.watch.until('hold.raised', item='WO-1/1', task='use')
    assert held['reason'] == 'missing_result'
    assert held['message'] == '${results.measure.measurement} is nan, which is no finite number'
    cell.kill_and_restart_node()
    hold = cell.watch.until_held()
    assert (hold.task, hold.reason) == ('use', 'missing_result')
    assert cell.watch.answer(hold.id, 'mark_done').accepted
    job = cell.watch.until_ended('WO-1')
    assert (job.packed, job.nonconforming) == (1, 0)
    assert got == [], 'the goal was sent'
    status, output, _ = run_verb(cell.folder, 'events', '--journal', str(path))
    assert status == 0
    records = [json.loads(line, parse_constant=pytest.fail) for line in output.splitlines()]
    (first,) = (r for r in records if r['event'] == 'task.succeeded' and r['task'] == 'measure')
    assert first['results']['measurement'] == {'$float': 'nan'}
    words = ['history', '--journal', str(path), '--job', 'WO-1', '--items']
    assert '"measurement": NaN' in run_verb(cell.folder, *words)[1]
    cell.stop()
