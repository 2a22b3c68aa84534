"""The life of the process that `sim-cell` is: what it serves, and how it ends."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import stuck_leaving
from action_caller import ActionCaller
from action_msgs.msg import GoalStatus
from bt_orchestrator_interfaces.action import Component
from builtin_interfaces.msg import Time
from program_process import ProgramProcess
from rclpy.action.graph import get_action_names_and_types
from rosgraph_msgs.msg import Clock
from sim_cell_process import SimCellProcess

CELL = """
cell: small_cell
conveyor:
  sections: 2
  action: /conveyor/index
  type: bt_orchestrator_interfaces/action/Conveyor
  task: MOVE_ONE_INDEX
components:
  near:
    section: 1
    action: near/task
    type: bt_orchestrator_interfaces/action/Component
    durations: {TASK_A: 0.1, TASK_C: 60.0}
  far: {section: 2, action: /far/task, type: bt_orchestrator_interfaces/action/Component}
"""
Start = Callable[..., SimCellProcess]


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Start]:
    """Give a function that starts the small cell with options."""
    started: list[SimCellProcess] = []

    def starter(*options: str, text: str = CELL) -> SimCellProcess:
        path = tmp_path / 'cell.yaml'
        path.write_text(text)
        started.append(SimCellProcess(path, *options))
        return started[-1]

    yield starter
    for process in started:
        process.stop()


@pytest.fixture
def ros() -> Iterator[ActionCaller]:
    caller = ActionCaller()
    yield caller
    caller.close()


def a_goal(task: str = 'TASK_A') -> Any:
    return Component.Goal(task=getattr(Component.Goal, task))


def until_there_are(ros: ActionCaller, names: set[str]) -> None:
    """Wait for just these actions; the graph remembers those of a killed process for 20 s."""

    def actions() -> set[str]:
        return {name for name, _ in get_action_names_and_types(ros.node)}

    assert ros.spin_for(30.0, lambda: actions() == names), actions()


@pytest.mark.parametrize('with_signal', [signal.SIGTERM, signal.SIGINT])
def test_stop_signal_aborts_goals_and_exits_cleanly(
    start: Start, ros: ActionCaller, with_signal: signal.Signals
) -> None:
    cell = start()
    assert cell.wait_ready() == 'sim-cell ready: 3 action servers'
    handles = [
        ros.start(name, Component, a_goal('TASK_C')) for name in ('/near/task', '/far/task')
    ]
    results = [handle.get_result_async() for handle in handles]
    ros.spin_for(0.2)  # the requests for results are on their way

    assert cell.stop(with_signal) == 0

    for result in results:
        assert ros.wait(result, 'the result').status == GoalStatus.STATUS_ABORTED
    assert [record['status'] for record in cell.records(event='ended')] == ['aborted', 'aborted']
    assert 'Traceback' not in cell.errors


def test_only_the_named_components_are_simulated(start: Start, ros: ActionCaller) -> None:
    cell = start('--only=far')
    assert cell.wait_ready() == 'sim-cell ready: 1 action server'

    assert ros.call('/far/task', Component, a_goal()).status == GoalStatus.STATUS_SUCCEEDED
    until_there_are(ros, {'/far/task'})


def test_two_processes_share_a_cell_and_a_log(start: Start, ros: ActionCaller) -> None:
    cells = [start('--only=far,conveyor'), start('--only', 'near')]
    for cell in cells:
        cell.wait_ready()

    for action in ('/far/task', '/near/task'):
        assert ros.call(action, Component, a_goal()).status == GoalStatus.STATUS_SUCCEEDED
    assert {r['component'] for r in cells[0].records(event='ended')} == {'near', 'far'}


def test_relative_names_are_in_the_namespace(start: Start, ros: ActionCaller) -> None:
    start('--namespace=cell_b', '--only=near,far').wait_ready()
    until_there_are(ros, {'/cell_b/near/task', '/far/task'})


def test_ros_arguments_are_obeyed(start: Start, ros: ActionCaller) -> None:
    start('--only=near', '--ros-args', '-r', '__ns:=/cell_c').wait_ready()
    until_there_are(ros, {'/cell_c/near/task'})


def test_simulated_time_is_obeyed(start: Start, ros: ActionCaller) -> None:
    clock = ros.node.create_publisher(Clock, '/clock', 1)
    start('--only=near', '--ros-args', '-p', 'use_sim_time:=true').wait_ready()
    ros.spin_until(lambda: clock.get_subscription_count() == 1, 'it to listen to the clock')
    clock.publish(Clock(clock=Time(sec=1000)))
    stamps: list[int] = []

    def note(message: Any) -> None:
        stamps.append(message.feedback.stamp.sec)

    handle = ros.start('/near/task', Component, a_goal('TASK_C'), on_feedback=note)
    result = handle.get_result_async()
    ros.spin_until(lambda: stamps, 'the first feedback')
    assert not ros.spin_for(0.5, result.done)
    clock.publish(Clock(clock=Time(sec=1060)))

    assert ros.wait(result, 'the result').status == GoalStatus.STATUS_SUCCEEDED
    assert stamps[0] in {0, 1000}


def test_server_forgets_goal_after_result_timeout(start: Start, ros: ActionCaller) -> None:
    start('--only=near', '--result-timeout=1.0').wait_ready()
    handle = ros.start('/near/task', Component, a_goal())
    ended = ros.result(handle)
    at_once = ros.result(handle)

    def forgotten() -> bool:
        return bool(ros.result(handle).status == GoalStatus.STATUS_UNKNOWN)

    ros.spin_until(forgotten, 'the goal to be forgotten')
    assert ended.status == at_once.status == GoalStatus.STATUS_SUCCEEDED


def test_callback_error_does_not_end_the_process(
    start: Start, ros: ActionCaller, tmp_path: Path
) -> None:
    """The error is a log that can be written no more: a pipe that nobody reads."""
    pipe = tmp_path / 'pipe'
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    cell = start('--only=near', f'--log={pipe}')
    cell.wait_ready()
    os.close(reader)

    request = ros.request('/near/task', Component, a_goal())
    ros.spin_until(lambda: 'Broken pipe' in cell.errors, 'the error to be reported')

    assert not request.done()
    assert cell.stop() == 0


@pytest.mark.parametrize(
    ('options', 'complaint'),
    [
        (['--speed=0'], 'expected a number greater than 0, found '),
        (['--speed=fast'], 'expected a number greater than 0, found '),
        (['--namespace=9lives'], 'expected a ROS namespace such as /cell_b, found '),
        (['--log=/no/such/folder/x'], 'cannot write the log /no/such/folder/x: No such file'),
        (['--log=/dev/full'], 'cannot write the log: No space left on device'),
        (
            ['--only=naer'],
            '--only naer: no component `naer` in cell `small_cell`; did you mean `near`?',
        ),
        (['--fail=near.TASKA=abort'], 'has no task `TASKA`; did you mean `TASK_A`?'),
        (['--ros-args', '--no-such-option'], 'ROS refuses its arguments: '),
    ],
)
def test_wrong_use_is_told_and_ends_with_status_2(
    start: Start, options: list[str], complaint: str
) -> None:
    cell = start(*options)

    assert cell.wait() == 2
    assert complaint in cell.errors
    assert 'Traceback' not in cell.errors


def test_a_wrong_cell_file_is_refused_with_status_1(start: Start) -> None:
    cell = start(text=CELL.replace('sections: 2', 'sektions: 2'))

    assert cell.wait() == 1
    assert 'cell.yaml:4:3: ' in cell.errors


@pytest.mark.parametrize('verb', ['sim-cell', 'run'])
def test_stuck_middleware_does_not_keep_process_alive(tmp_path: Path, verb: str) -> None:
    (tmp_path / 'cell.yaml').write_text(CELL)
    process = ProgramProcess(
        [verb, '--cell', str(tmp_path / 'cell.yaml')], tmp_path, verb, [stuck_leaving.__file__]
    )
    try:
        process.wait_ready()
        assert process.stop() == 1
        assert 'Timeout' in process.errors
        assert 'File "' in process.errors, 'it says where'
    finally:
        process.kill()
