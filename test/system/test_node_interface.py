"""What others rely on: topics, parameters, names (formats: ROS names of the node)."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from bt_orchestrator_interfaces.msg import CellDescription
from bt_orchestrator_interfaces.srv import GetEvents
from cell_processes import (
    SMALL_CELL,
    SPEED,
    CellProcesses,
    StartCell,
    remembering,
    run_verb,
)
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from node_watcher import NodeWatcher
from rcl_interfaces.srv import DescribeParameters, GetParameters

from bt_orchestrator.engine.runtime.overview import description_of
from bt_orchestrator.ros.qos import LATCHED
from bt_orchestrator.ros.types.action_types import InstalledActionTypes
from bt_orchestrator.ros.types.status_messages import cell_description
from bt_orchestrator.script.cell_file import read_cell

pytestmark = pytest.mark.every_distro

NODE = 'bt_orchestrator'

NAMES = ['cell', 'trees', 'tick_rate_hz', 'executor', 'auto_start', 'server_timeout']

SLOW_CELL = remembering(SMALL_CELL.replace('TASK_A: 1.0', 'TASK_A: 100.0'))
NOMINAL_ITEM_S = 200.0
"""Of that cell: `work` and `pack`. What a busy machine adds is far less, at any speed."""

HAS_EVENTS_EXECUTOR = importlib.util.find_spec('rclpy.experimental') is not None


def parameter_values(watch: NodeWatcher, names: list[str]) -> list[Any]:
    response = watch.call(GetParameters, 'get_parameters', GetParameters.Request(names=names))
    return list(response.values)


# --- topics, parameters and names of a node without options -------------------------------------


@pytest.mark.long
def test_what_a_node_offers(small_cell: CellProcesses) -> None:
    cell = small_cell
    _who_comes_late_is_told_what_exists(cell)
    _the_policy_for_dds_security_names_what_the_node_has(cell)
    _parameters_say_what_they_are(cell)
    _events_are_numbered_without_gaps_and_in_time(cell)
    _events_that_were_missed_can_be_had(cell)
    _who_comes_late_gets_the_last_status(cell)
    _the_status_follows_the_events(cell)
    cell.stop()


def _who_comes_late_is_told_what_exists(cell: CellProcesses) -> None:
    descriptions: list[Any] = []
    node, name = cell.watch.ros.node, cell.watch.name
    node.create_subscription(CellDescription, f'{name}/cell', descriptions.append, LATCHED)
    cell.watch.ros.spin_until(lambda: descriptions, 'the description of the cell')
    types = InstalledActionTypes()
    assert cell_description(descriptions[0]) == description_of(read_cell(cell.cell, types), types)


def _the_policy_for_dds_security_names_what_the_node_has(cell: CellProcesses) -> None:
    text = (Path(__file__).parents[2] / 'docs' / 'dds_security.md').read_text()
    policy = ElementTree.fromstring(text.partition('```xml\n')[2].partition('```')[0])
    by_path = {element.get('path'): element for element in policy.iter('enclave')}

    def named(enclave: str, kind: str, right: str) -> set[str]:
        of = by_path[f'/line/{enclave}'].iterfind(f".//{kind}s[@{right}='ALLOW']/{kind}")
        return {str(element.text) for element in of}

    node = cell.watch.ros.node
    served = {name for name, _ in node.get_service_names_and_types_by_node(NODE, '/')}
    topics = {name for name, _ in node.get_publisher_names_and_types_by_node(NODE, '/')}
    offered = named('node', 'service', 'reply')
    assert offered <= served
    assert named('operator', 'service', 'request') <= offered
    assert named('node', 'topic', 'publish') <= topics
    assert named('operator', 'topic', 'subscribe') <= topics
    assert named('node', 'action', 'call') == named('controllers', 'action', 'execute')


def _parameters_say_what_they_are(cell: CellProcesses) -> None:
    request = DescribeParameters.Request(names=NAMES)
    response = cell.watch.call(DescribeParameters, 'describe_parameters', request)

    descriptors = {d.name: d for d in response.descriptors}
    assert sorted(descriptors) == sorted(NAMES)
    assert all(d.description and d.read_only for d in descriptors.values())
    assert 'Hz' in descriptors['tick_rate_hz'].description
    assert descriptors['tick_rate_hz'].floating_point_range[0].from_value > 0
    assert descriptors['executor'].additional_constraints == 'single or events'
    values = dict(zip(NAMES, parameter_values(cell.watch, NAMES), strict=True))
    assert values['cell'].string_value == str(cell.cell)
    assert list(values['trees'].string_array_value) == [str(cell.folder)]
    assert (values['tick_rate_hz'].double_value, values['auto_start'].bool_value) == (10.0, True)


def _events_are_numbered_without_gaps_and_in_time(cell: CellProcesses) -> None:
    cell.run_small(quantity=4)
    cell.watch.until_ended('WO-1')
    cell.watch.until('cell.state_changed', state='Complete')

    cell.watch.assert_gapless()
    assert len(cell.watch.events) > 50
    times = [event['time'] for event in cell.watch.events]
    assert times == sorted(times)


def _events_that_were_missed_can_be_had(cell: CellProcesses) -> None:
    """Those of the step before."""
    last = cell.watch.until_state('Complete').seq
    page = events_after(cell, 3, 5)
    assert [message.seq for message in page.events] == [4, 5, 6, 7, 8]
    assert (page.accepted, page.first_seq, page.last_seq) == (True, 1, last)
    records = [json.loads(message.record) for message in page.events]
    assert records == [e for e in cell.watch.events if 4 <= e['seq'] <= 8]
    missed = next(event for event in cell.watch.events if event['seq'] == 6)
    cell.watch.events.remove(missed)
    cell.watch.until(missed['event'], seq=6)
    cell.watch.assert_gapless()
    assert events_after(cell, last, 0).events == []

    words = ['events', '--since-seq', '2', '--count', str(last - 2)]
    status, output, _ = run_verb(cell.folder, *words)
    assert status == 0
    assert [json.loads(line)['seq'] for line in output.splitlines()] == list(range(3, last + 1))


def events_after(cell: CellProcesses, seq: int, most: int) -> Any:
    request = GetEvents.Request(after_seq=seq, most=most)
    return cell.watch.call(GetEvents, 'get_events', request)


def _who_comes_late_gets_the_last_status(cell: CellProcesses) -> None:
    last = cell.watch.until_state('Complete').seq  # told, and not only recorded

    late = NodeWatcher()
    try:
        late.connect(wait_servers=False)
        first = late.statuses[0]
    finally:
        late.close()
    assert (first.cell, first.state) == ('small_cell', 'Complete')
    assert first.seq == cell.watch.events[-1]['seq'] == last
    assert [(job.id, job.packed) for job in first.jobs] == [('WO-1', 4)]
    assert late.events == []


def _the_status_follows_the_events(cell: CellProcesses) -> None:
    """The task of this step is ended by the end of the node."""
    cell.run_small('', 'TASK_B', order='WO-2')
    started = cell.watch.until('task.started', task='work', job='WO-2')

    status = cell.watch.until_status(
        lambda s: s.seq >= started['seq'] and s.sections[1].running[0].feedback, 'the feedback'
    )
    (task,) = status.sections[1].running
    assert (task.id, task.name, task.goal) == ('work', 'TASK_B', started['goal'])
    assert (task.component, task.expected_s) == ('worker', 1200.0), 'nominal, nothing was seen yet'
    assert 'TASK_B' in task.feedback
    assert status.sections[1].slot == status.sections[1].item == 'WO-2/1'
    assert [c.name for c in status.components if c.task] == ['worker']
    job = next(job for job in status.jobs if job.id == 'WO-2')
    assert (job.state, job.placed) == ('Running', 1)
    # The pace by the cell file says 1200 s; what was seen of a cell at SPEED is 60 s.
    cell.watch.until_status(
        lambda s: any(job.id == 'WO-2' and 0 < job.expected_end_s < 600 for job in s.jobs),
        'a forecast',
    )


# --- with options of the node -------------------------------------------------------------------


@pytest.mark.parametrize('forecast', ['--expected-end', '--no-expected-end'])
def test_expected_end_follows_observations_across_restart(
    start_cell: StartCell, tmp_path: Path, forecast: str
) -> None:
    journal = tmp_path / 'cell' / 'journal.sqlite3'
    options = ['--journal', str(journal), '--auto-resume', forecast]
    cell = start_cell(SLOW_CELL, speed=100 * SPEED, run_options=options)
    cell.connect()
    cell.run_small(quantity=500)
    for taken_over in (False, True):
        if taken_over:
            cell.kill_and_restart_node()
            cell.watch.connect_anew()
        cell.watch.until_status(
            lambda s: any(job.packed >= 5 and is_as_seen(job) for job in s.jobs),
            f'an expected end by what was seen (taken over: {taken_over})',
        )
    cell.stop()


def is_as_seen(job: Any) -> bool:
    """Tell whether a job is expected to end sooner than the nominal times of the cell say."""
    nominal_s: float = (job.quantity - job.packed) * NOMINAL_ITEM_S
    return bool(0 < job.expected_end_s < nominal_s / 2)


def test_diagnostics_come_once_a_second(start_cell: StartCell) -> None:
    cell = start_cell(fail=['worker.=absent', 'feeder.TASK_A=abort'])
    cell.connect(wait_servers=False)
    cell.watch.wait_servers(but='worker')
    cell.run_small()
    hold = cell.watch.until_held()
    received: list[Any] = []
    ros = cell.watch.ros
    ros.node.create_subscription(DiagnosticArray, '/diagnostics', received.append, 10)
    ros.spin_until(lambda: len(received) >= 4, 'four diagnostics')

    stamps = [m.header.stamp.sec + m.header.stamp.nanosec / 1e9 for m in received]
    assert (stamps[-1] - stamps[0]) / (len(stamps) - 1) == pytest.approx(1.0, abs=0.3)
    parts = {status.name.split(': ')[1]: status for status in received[-1].status}
    assert parts['cell'].level == parts['action servers'].level == DiagnosticStatus.WARN
    assert {pair.key for pair in parts['cell'].values} >= {'state', f'hold {hold.id}'}
    assert [(v.key, v.value) for v in parts['action servers'].values] == [
        ('worker', 'worker/task')
    ]
    cell.stop()


def test_ros_arguments_set_parameters_and_namespace(start_cell: StartCell) -> None:
    options = ['--ros-args', '-p', 'tick_rate_hz:=20.0']
    cell = start_cell(namespace='/x', remapped=True, run_options=options)
    cell.connect()

    assert cell.watch.name == '/x/bt_orchestrator'
    (value,) = parameter_values(cell.watch, ['tick_rate_hz'])
    assert value.double_value == 20.0
    cell.run_small()
    assert cell.watch.until_ended('WO-1').packed == 1
    cell.stop()


@pytest.mark.parametrize(
    ('parameter', 'words'),
    [
        ('executor:=turbo', ['executor', 'single', 'events', 'turbo']),
        ('inspection:=other', ['inspection', 'builtin', 'py_trees_ros', 'other']),
        ('tick_rate_hz:=0.0', ['tick_rate_hz']),
        ('tick_rate_hz:=often', ['tick_rate_hz']),
        ('cell:=/nowhere/cell.yaml', ['/nowhere/cell.yaml']),
        ('auto_start:=[', ['auto_start']),
    ],
)
def test_impossible_parameter_is_refused_with_explanation(
    small_cell_file: Path, parameter: str, words: list[str]
) -> None:
    status, _, errors = run_verb(
        small_cell_file.parent,
        'run',
        '--cell',
        str(small_cell_file),
        '--ros-args',
        '-p',
        parameter,
    )
    assert status == 1
    assert all(word in errors for word in words), errors


@pytest.mark.skipif(not HAS_EVENTS_EXECUTOR, reason='this rclpy has no events executor')
def test_events_executor_runs_cell_to_end(start_cell: StartCell) -> None:
    cell = start_cell(run_options=['--executor', 'events'], fail=['worker.TASK_A#1=abort'])
    cell.connect()
    cell.run_small(', retries: 1', quantity=4)

    assert cell.watch.until_ended('WO-1').packed == 4
    assert cell.watch.reasons('work') == ['aborted']
    cell.run_small('', 'TASK_B', order='WO-2')
    cell.watch.until('task.started', task='work', job='WO-2')
    cell.stop()


@pytest.mark.skipif(HAS_EVENTS_EXECUTOR, reason='this rclpy has the events executor')
def test_request_for_missing_events_executor_is_refused(small_cell_file: Path) -> None:
    status, _, errors = run_verb(
        small_cell_file.parent, 'run', '--cell', str(small_cell_file), '--executor', 'events'
    )
    assert status == 1
    assert 'no events executor' in errors
    assert 'use single' in errors


# --- without the inside of rclpy ----------------------------------------------------------------

BLOCKED = (str(Path(__file__).parents[1] / 'blocked_inside.py'),)


@pytest.mark.parametrize(('client', 'warnings'), [('auto', 1), ('plain', 0)])
def test_node_without_rclpy_internals_runs_cell_to_end(
    start_cell: StartCell, client: str, warnings: int
) -> None:
    options = ['--client', client]
    cell = start_cell(run_options=options, fail=['worker.TASK_A#1=abort'], node_program=BLOCKED)
    cell.connect()
    cell.run_small(', retries: 1', quantity=4)

    assert cell.watch.until_ended('WO-1').packed == 4
    assert cell.watch.reasons('work') == ['aborted']
    cell.run_small('', 'TASK_B', order='WO-2')
    cell.watch.until('task.started', task='work', job='WO-2')
    assert cell.node.stop() == 0  # cancels what runs
    assert cell.node.errors.count('has another inside than the one that is known') == warnings
    assert cell.node.errors.count('rclpy.impl is blocked') == warnings
