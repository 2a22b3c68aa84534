"""Components with ordinary ROS 2 actions: no task field, no task_result, nested fields."""

from __future__ import annotations

import pytest
from cell_processes import SMALL_CELL, CellProcesses, StartCell

pytestmark = pytest.mark.every_distro

CELL = (
    SMALL_CELL
    + """
  counter:
    section: 2
    action: counter/count
    type: test_msgs/action/Fibonacci
  nester:
    section: 2
    action: nester/nest
    type: test_msgs/action/NestedMessage
    results: {NEST: {nested_field: {float64_value: 2.5, int32_value: 9, bool_value: true}}}
"""
)

SCRIPT = """
script: any_action
sections:
  1:
    - {id: feed, task: TASK_A, action: feeder/task, qty_change: 1}
  2:
    - {id: count, task: COUNT, action: counter/count, args: {order: 5}}
    - id: nest
      task: NEST
      action: nester/nest
      args:
        nested_field: {int32_value: "${item.number}", bool_value: true}
        nested_different_pkg: {sec: 12, nanosec: 34}
    - id: work
      task: TASK_A
      action: worker/task
      args:
        special_argument_1: "seen ${results.nest.nested_field.int32_value}"
        special_argument_2: "${results.nest.nested_field.float64_value}"
      when: "${results.nest.nested_field.bool_value}"
    - {id: pack, task: TASK_A, action: packer/task, qty_change: -1}
"""


def test_any_action_type(start_cell: StartCell) -> None:
    cell = start_cell(CELL)
    cell.connect()
    _any_action_type_takes_part_in_a_script(cell)
    _a_parameter_that_no_goal_field_can_hold_is_refused(cell)
    cell.stop()


def _any_action_type_takes_part_in_a_script(cell: CellProcesses) -> None:
    cell.watch.submit(cell.script(SCRIPT, 'any_action'), quantity=2)

    job = cell.watch.until_ended('WO-1')
    assert (job.packed, job.nonconforming) == (2, 0)
    count, nest, work = (
        cell.watch.until('task.started', item='WO-1/2', task=task)
        for task in ('count', 'nest', 'work')
    )
    assert count['args'] == {'order': 5}
    assert nest['args']['nested_field'] == {'int32_value': 2, 'bool_value': True}
    assert work['args'] == {'special_argument_1': 'seen 9', 'special_argument_2': 2.5}
    assert cell.watch.until('task.succeeded', task='count')['results'] == {'sequence': []}
    done = cell.watch.until('task.succeeded', task='nest')['results']
    assert done['nested_field']['float64_value'] == 2.5


def _a_parameter_that_no_goal_field_can_hold_is_refused(cell: CellProcesses) -> None:
    text = SCRIPT.replace('order: 5', 'order: "${params.length}"')
    path = cell.script(text + 'params: {length: {type: int}}\n', 'any_action')

    response = cell.watch.ask_submit(path, order='WO-2', params={'length': str(2**40)})
    assert not response.accepted
    (finding,) = response.findings
    assert 'length' in finding
    cell.watch.submit(path, order='WO-2', params={'length': '6'})
    cell.watch.until_ended('WO-2')
    started = cell.watch.until('task.started', task='count', job='WO-2')
    assert started['args'] == {'order': 6}
