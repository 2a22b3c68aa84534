"""Jobs of different scripts run back to back without draining the line (semantics 5.2)."""

from __future__ import annotations

from typing import Any

from cell_processes import CellProcesses, small_script

INITIALIZATION = """
initialization:
  - {id: ready_feeder, task: PREPARE, action: feeder/task}
  - {id: ready_worker, task: PREPARE, action: worker/task}
"""


def test_jobs_of_different_scripts(small_cell: CellProcesses) -> None:
    _the_second_job_follows_while_the_first_is_on_the_line(small_cell)
    _the_source_waits_while_its_components_are_being_initialized(small_cell)
    small_cell.stop()


def _the_second_job_follows_while_the_first_is_on_the_line(
    cell: CellProcesses,
) -> None:
    watch = cell.watch
    first = cell.script(small_script('first', task='TASK_C') + INITIALIZATION, 'first')
    second = cell.script(small_script('second') + INITIALIZATION, 'second')
    watch.submit(first, order='WO-1', quantity=2)
    watch.submit(second, order='WO-2', quantity=2)
    assert watch.until_ended('WO-1').packed == 2
    assert watch.until_ended('WO-2').packed == 2

    def when(event: str, **about: Any) -> int:
        return int(watch.until(event, **about)['seq'])

    source_done = when('cycle.completed', section=1, item='WO-1/2')
    feeder_readied = when('task.started', job='WO-2', task='ready_feeder')
    first_placed = when('item.placed', item='WO-2/1')
    last_packed = when('item.removed', item='WO-1/2')
    worker_done = when('cycle.completed', section=2, item='WO-1/2')
    worker_readied = when('task.started', job='WO-2', task='ready_worker')
    first_worked = when('task.started', item='WO-2/1', task='work')
    assert source_done < feeder_readied < first_placed < last_packed, 'both are on the belt'
    assert worker_done < worker_readied < first_worked
    assert when('job.started', job='WO-2') < when('job.completed', job='WO-1')


def _the_source_waits_while_its_components_are_being_initialized(
    cell: CellProcesses,
) -> None:
    watch = cell.watch
    slow = """
initialization:
  - {id: ready_worker, task: TASK_C, action: worker/task}
  - {id: ready_feeder, task: PREPARE, action: feeder/task}
initialization_dependencies:
  - {upstream: ready_worker, downstream: ready_feeder}
"""
    watch.submit(cell.script(small_script('first'), 'first'), order='WO-3')
    watch.submit(cell.script(small_script('slow') + slow, 'slow'), order='WO-4')
    watch.until('task.started', job='WO-4', task='ready_worker')

    watch.until_status(
        lambda s: any('initialization' in wait.reason for wait in s.sections[0].waits),
        'section 1 to wait for initialization',
    )
    assert watch.seen('job.completed', job='WO-3'), 'the line has drained'
    assert watch.until_ended('WO-4').packed == 1
