"""Simulated controllers in a process of their own, asked by real action clients."""

from __future__ import annotations

import uuid
from collections.abc import Iterator
from itertools import groupby
from typing import Any

import pytest
from action_caller import ActionCaller
from action_msgs.msg import GoalStatus
from bt_orchestrator_interfaces.action import Component, Conveyor
from rclpy.qos import DurabilityPolicy, QoSProfile
from ros_domain import kept_domain
from sim_cell_process import SimCellProcess
from std_msgs.msg import String
from test_msgs.action import Fibonacci

TASK_S = 0.2
CELL = """
cell: faulty_cell
conveyor:
  sections: 3
  action: /conveyor/index
  type: bt_orchestrator_interfaces/action/Conveyor
  task: MOVE_ONE_INDEX
  duration: 0.1
components:
  counter: {section: 1, action: /counter/count, type: test_msgs/action/Fibonacci}
"""
ARM = """
  {name}:
    section: 1
    action: /{name}/task
    type: bt_orchestrator_interfaces/action/Component
    state: {{topic: /{name}/state, type: std_msgs/msg/String, field: data, ready: [READY, IDLE]}}
    durations: {{PREPARE: 0.0, TASK_A: 0.2, TASK_B: 4.0, TASK_C: 60.0}}
    results: {{TASK_B: {{measurement: 2.5}}}}
"""
FAULTS = {
    'good': [],
    'liar': ['#*=false'],
    'refuser': ['TASK_A#*=reject'],
    'aborter': ['#*=abort'],
    'quitter': ['#*=cancel'],
    'hanger': ['TASK_A#*=hang'],
    'stubborn': ['TASK_A#*=ignore_cancel'],
    'late': ['#*=late:3.8'],
    'mute': ['#1=mute'],
    'mortal': ['#1=die:3'],
    'tired': ['#1=not_ready:2'],
    'sleeper': ['#0=not_ready'],
    'silent': ['=silent'],
    'latecomer': ['=absent:8'],
}


@pytest.fixture(scope='module')
def cell(tmp_path_factory: pytest.TempPathFactory) -> Iterator[SimCellProcess]:
    path = tmp_path_factory.mktemp('sim_cell') / 'cell.yaml'
    path.write_text(CELL + ''.join(ARM.format(name=name) for name in FAULTS))
    options = [f'--fail={name}.{fault}' for name, faults in FAULTS.items() for fault in faults]
    with kept_domain():
        process = SimCellProcess(path, '--speed=2', '--feedback=0.5', *options)
        try:
            line = process.wait_ready()
            assert line == 'sim-cell ready: 15 action servers, 1 absent at first'
            yield process
        finally:
            status = process.stop()
    assert status == 0
    assert 'Traceback' not in process.errors


@pytest.fixture(scope='module')
def caller(cell: SimCellProcess) -> Iterator[ActionCaller]:
    caller = ActionCaller()
    yield caller
    caller.close()


@pytest.fixture
def ros(cell: SimCellProcess, caller: ActionCaller) -> ActionCaller:
    """Give the client, with the cell running."""
    return caller


def a_goal(task: str = 'TASK_A') -> Any:
    return Component.Goal(task=getattr(Component.Goal, task))


def do(ros: ActionCaller, name: str, task: str = 'TASK_A') -> Any:
    return ros.call(f'/{name}/task', Component, a_goal(task))


def start(ros: ActionCaller, name: str, task: str) -> Any:
    handle = ros.start(f'/{name}/task', Component, a_goal(task))
    assert handle.accepted
    return handle


def text_id(handle: Any) -> str:
    return str(uuid.UUID(bytes=bytes(handle.goal_id.uuid)))


def test_task_succeeds_with_results_from_cell_file(ros: ActionCaller) -> None:
    end = do(ros, 'good', 'TASK_B')

    assert end.status == GoalStatus.STATUS_SUCCEEDED
    assert end.result == Component.Result(task_result=True, item_present=True, measurement=2.5)


def test_speed_divides_durations_and_the_log_tells_them(
    ros: ActionCaller, cell: SimCellProcess
) -> None:
    handle = start(ros, 'good', 'TASK_B')
    ros.result(handle)

    records = cell.records(goal=text_id(handle))
    assert [record['event'] for record in records] == ['accepted', 'started', 'ended']
    assert {(record['component'], record['task']) for record in records} == {('good', 'TASK_B')}
    assert records[-1]['status'] == 'succeeded'
    # 4 s at twice the speed; its start is written down a moment after it.
    assert 1.9 <= records[2]['time'] - records[1]['time'] < 3.9


def until_feedback(ros: ActionCaller, action: str, kind: Any, goal: Any) -> None:
    """Send short goals until feedback comes: a server may find a client's topics last."""
    heard: list[Any] = []
    ros.spin_until(
        lambda: ros.call(action, kind, goal, on_feedback=heard.append) and heard, 'feedback'
    )


def test_feedback_comes_at_the_start_and_at_intervals(ros: ActionCaller) -> None:
    until_feedback(ros, '/good/task', Component, a_goal('PREPARE'))
    seen: list[Any] = []
    ros.call('/good/task', Component, a_goal('TASK_B'), on_feedback=seen.append)

    texts = [message.feedback.current_sub_task for message in seen]
    assert texts[0] == 'TASK_B 0%'
    assert len(texts) >= 3
    assert all(text.startswith('TASK_B ') for text in texts)
    stamps = [message.feedback.stamp for message in seen]
    assert 0 < stamps[0].sec <= stamps[-1].sec


def test_a_task_without_duration_succeeds(ros: ActionCaller) -> None:
    assert do(ros, 'good', 'PREPARE').status == GoalStatus.STATUS_SUCCEEDED


def test_many_components_work_at_the_same_time(ros: ActionCaller, cell: SimCellProcess) -> None:
    handles = [start(ros, name, 'TASK_B') for name in ('good', 'stubborn', 'refuser', 'hanger')]
    for handle in handles:
        assert ros.result(handle).status == GoalStatus.STATUS_SUCCEEDED

    starts = [cell.records(goal=text_id(h), event='started')[0]['time'] for h in handles]
    ends = [cell.records(goal=text_id(h), event='ended')[0]['time'] for h in handles]
    assert max(starts) < min(ends)


def test_the_conveyor_moves(ros: ActionCaller) -> None:
    end = ros.call('/conveyor/index', Conveyor, Conveyor.Goal(task=Conveyor.Goal.MOVE_ONE_INDEX))

    assert end.status == GoalStatus.STATUS_SUCCEEDED
    assert end.result.task_result


def test_any_action_type_works_by_name_and_type(ros: ActionCaller) -> None:
    until_feedback(ros, '/counter/count', Fibonacci, Fibonacci.Goal(order=1))
    seen: list[Any] = []
    end = ros.call('/counter/count', Fibonacci, Fibonacci.Goal(order=5), on_feedback=seen.append)

    assert end.status == GoalStatus.STATUS_SUCCEEDED
    assert list(end.result.sequence) == []
    assert list(seen[0].feedback.sequence) == []


def test_a_second_goal_is_rejected_while_one_runs(ros: ActionCaller, cell: SimCellProcess) -> None:
    first = start(ros, 'good', 'TASK_B')
    second = ros.start('/good/task', Component, a_goal())

    assert not second.accepted
    rejected = cell.records(event='rejected', goal=text_id(second))
    assert rejected[0]['why'] == f'busy with goal {text_id(first)}'
    assert ros.result(first).status == GoalStatus.STATUS_SUCCEEDED


def test_a_cancel_request_is_obeyed_at_once(ros: ActionCaller) -> None:
    handle = start(ros, 'good', 'TASK_C')
    answer = ros.wait(handle.cancel_goal_async(), 'the answer to the cancel request')

    assert len(answer.goals_canceling) == 1
    assert ros.result(handle).status == GoalStatus.STATUS_CANCELED
    assert do(ros, 'good').status == GoalStatus.STATUS_SUCCEEDED


@pytest.mark.parametrize(
    ('name', 'status'),
    [
        ('liar', GoalStatus.STATUS_SUCCEEDED),
        ('aborter', GoalStatus.STATUS_ABORTED),
        ('quitter', GoalStatus.STATUS_CANCELED),
    ],
)
def test_a_goal_can_end_badly(ros: ActionCaller, name: str, status: int) -> None:
    end = do(ros, name)

    assert end.status == status
    assert not end.result.task_result


def test_a_goal_can_be_refused(ros: ActionCaller) -> None:
    assert not ros.start('/refuser/task', Component, a_goal()).accepted
    assert do(ros, 'refuser', 'PREPARE').status == GoalStatus.STATUS_SUCCEEDED


def test_a_goal_can_be_late(ros: ActionCaller, cell: SimCellProcess) -> None:
    handle = start(ros, 'late', 'TASK_A')

    assert ros.result(handle).status == GoalStatus.STATUS_SUCCEEDED
    times = [record['time'] for record in cell.records(goal=text_id(handle))]
    assert times[-1] - times[0] >= (TASK_S + 3.8) / 2


def test_a_goal_can_hang_until_it_is_cancelled(ros: ActionCaller) -> None:
    handle = start(ros, 'hanger', 'TASK_A')
    result = handle.get_result_async()

    assert not ros.spin_for(TASK_S * 4, result.done)
    ros.wait(handle.cancel_goal_async(), 'the answer to the cancel request')
    assert ros.wait(result, 'the result').status == GoalStatus.STATUS_CANCELED


def test_a_cancel_request_can_be_refused(ros: ActionCaller, cell: SimCellProcess) -> None:
    handle = start(ros, 'stubborn', 'TASK_A')
    result = handle.get_result_async()
    answer = ros.wait(handle.cancel_goal_async(), 'the answer to the cancel request')

    assert not answer.goals_canceling
    assert not ros.spin_for(TASK_S * 4, result.done)
    assert cell.records(event='cancel', goal=text_id(handle), obeyed=False)


def test_a_request_can_stay_without_an_answer(ros: ActionCaller, cell: SimCellProcess) -> None:
    request = ros.request('/mute/task', Component, a_goal())
    ros.spin_until(lambda: cell.records(event='muted'), 'the request to arrive')

    assert not ros.spin_for(TASK_S * 4, request.done)
    assert do(ros, 'mute').status == GoalStatus.STATUS_SUCCEEDED
    assert len(cell.records(event='started', component='mute')) == 1
    assert not request.done()


def test_restarted_server_knows_no_earlier_goal(ros: ActionCaller, cell: SimCellProcess) -> None:
    client = ros.client('/mortal/task', Component)
    handle = start(ros, 'mortal', 'TASK_A')
    result = handle.get_result_async()
    ros.spin_until(lambda: not client.server_is_ready(), 'the server to vanish')
    ros.spin_until(client.server_is_ready, 'the server to be back')

    assert cell.records(event='died', goal=text_id(handle))
    assert not result.done()
    assert ros.result(handle).status == GoalStatus.STATUS_UNKNOWN
    assert do(ros, 'mortal').status == GoalStatus.STATUS_SUCCEEDED


def test_a_server_can_come_late(ros: ActionCaller, cell: SimCellProcess) -> None:
    assert do(ros, 'latecomer').status == GoalStatus.STATUS_SUCCEEDED

    def appeared(name: str) -> float:
        return float(cell.records(event='appeared', component=name)[0]['time'])

    assert appeared('latecomer') - appeared('good') >= 8 / 2


class States:
    """Listens to one state topic."""

    def __init__(self, ros: ActionCaller, name: str, latched: bool = True) -> None:
        durability = DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE
        self.values: list[str] = []
        self._ros = ros
        self._subscription = ros.node.create_subscription(
            String,
            f'/{name}/state',
            lambda message: self.values.append(message.data),
            QoSProfile(depth=10, durability=durability),
        )

    def __enter__(self) -> States:
        return self

    def __exit__(self, *exception: object) -> None:
        self._ros.node.destroy_subscription(self._subscription)


@pytest.mark.parametrize('latched', [True, False])
def test_state_topic_tells_ready_to_any_subscriber(ros: ActionCaller, latched: bool) -> None:
    with States(ros, 'good', latched) as states:
        ros.spin_until(lambda: states.values, 'the state')

    assert set(states.values) == {'READY'}


def test_a_component_can_become_unready_for_a_time(ros: ActionCaller) -> None:
    with States(ros, 'tired') as states:
        ros.spin_until(lambda: states.values, 'the first state')
        do(ros, 'tired')
        ros.spin_until(lambda: 'NOT_READY' in states.values, 'the state to change')
        ros.spin_until(lambda: states.values[-1] == 'READY', 'the state to change back')

    changes = [value for value, _ in groupby(states.values)]  # each is said again once a second
    assert changes == ['READY', 'NOT_READY', 'READY']


def test_a_component_can_be_unready_from_the_start(ros: ActionCaller) -> None:
    with States(ros, 'sleeper') as states:
        ros.spin_until(lambda: len(states.values) >= 2, 'the state to be repeated')

    assert set(states.values) == {'NOT_READY'}


def test_a_state_topic_can_be_silent(ros: ActionCaller) -> None:
    with States(ros, 'silent') as silent, States(ros, 'good', latched=False) as good:
        ros.spin_until(lambda: len(good.values) >= 2, 'the other states to be repeated')

    assert not silent.values
