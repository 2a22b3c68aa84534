"""Tree watchers at a running node: the wire contract, spoken by a client of our own."""

from __future__ import annotations

import math
import re
import threading
from collections.abc import Iterator
from functools import partial
from itertools import groupby
from typing import Any

import pytest
from bt_orchestrator_interfaces.action import Component
from cell_processes import STATELESS_CELL, CellProcesses, StartCell
from py_trees_ros_interfaces.msg import Behaviour
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from thread_servers import ThreadServers
from watching_client import ON_CHANGE_S, WatcherProcess, WatchingClient, parameters

from bt_orchestrator.model.limits import STREAMS

pytestmark = pytest.mark.every_distro

WORK = 'work (TASK_A)'
LONG_WORK = 'work (TASK_B)'

LEASE_S = 60.0
"""More than the middleware (20 s) and the grace (5 s) take to be sure that a watcher is dead."""


@pytest.fixture
def client() -> Iterator[WatchingClient]:
    client = WatchingClient()
    yield client
    client.close()


def at_work(cell: CellProcesses, order: str) -> None:
    """Let the cell begin a task that lasts a minute."""
    cell.run_small(task='TASK_B', order=order)
    cell.watch.until('task.started', task='work', job=order)


def end_work(cell: CellProcesses, order: str) -> None:
    """End such a task before its time, and wait until the cell is idle."""
    goal = cell.watch.until('task.started', task='work', job=order)['goal']
    cell.watch.ros.spin_until(lambda: cell.goals(event='started', goal=goal), 'the goal to run')
    cell.watch.ros.cancel_of_another('/worker/task', Component, goal)
    cell.watch.ros.spin_until(lambda: is_completed(cell, order), f'the end of {order}')
    cell.watch.until_ended(order)
    cell.watch.until_state('Complete')


def is_completed(cell: CellProcesses, order: str) -> bool:
    """Tell whether a job has ended; answer the hold of a task that somebody else cancelled."""
    for hold in cell.watch.status.holds:
        cell.watch.answer(hold.id, 'mark_done')
    return bool(cell.watch.seen('job.completed', job=order))


# --- one cell without options: what reads and refuses -------------------------------------------


@pytest.mark.long
@pytest.mark.timeout(600)
def test_watchers_of_one_cell(small_cell: CellProcesses, client: WatchingClient) -> None:
    cell = small_cell
    at_work(cell, 'WO-1')
    _who_attaches_in_the_middle_sees_the_present_once(client)
    _a_period_repeats_the_unchanged_with_what_was_asked_for(client)
    end_work(cell, 'WO-1')
    _every_malformed_call_is_answered(cell, client)
    _too_many_streams_are_refused_with_an_answer(client)
    killed = _a_watcher_is_killed(client)
    _a_topic_asked_for_by_name_is_shared(cell, client)
    _a_subscriber_that_comes_late_misses_nothing(cell, client)
    _the_blackboard_is_listed_and_followed(cell, client)
    _the_blackboard_of_the_visited_path_with_what_is_done_there(cell, client)
    _the_stream_of_a_killed_watcher_ends_and_the_cell_goes_on(cell, client, killed)
    cell.stop()


def _who_attaches_in_the_middle_sees_the_present_once(client: WatchingClient) -> None:
    topic = client.open()
    seen = client.watch(topic)

    client.until(seen, lambda s: s.status(LONG_WORK) == Behaviour.RUNNING, 'at work')
    first = len(seen)
    client.ros.spin_for(1.0)
    assert len(seen) == first, 'nothing has changed since'
    assert client.close_stream(topic)


def _a_period_repeats_the_unchanged_with_what_was_asked_for(client: WatchingClient) -> None:
    topic = client.open(parameters(0.2, data=True, activity=True))
    seen = client.watch(topic)

    client.ros.spin_until(lambda: len(seen) >= 4, 'repeated snapshots')
    assert [s.message.changed for s in seen[1:4]] == [False] * 3
    visited = {pair.key: pair.value for pair in seen[3].message.blackboard_on_visited_path}
    assert visited == {
        '/small_cell/belt': 'at rest',
        '/small_cell/beat': '2',
        '/small_cell/ready/worker': 'True',
    }
    statistics = seen[3].message.statistics
    assert 0 < statistics.tick_interval_average < 10, 'seconds: a tenth where nobody else works'
    assert statistics.tick_duration > 0

    assert client.reconfigure(topic, parameters(ON_CHANGE_S))
    client.until(seen, lambda s: not s.message.blackboard_on_visited_path, 'reconfigured')
    count = len(seen)
    client.ros.spin_for(1.0)
    assert len(seen) == count
    assert client.close_stream(topic)


BAD_NAMES = [
    *('bad name', '/1st', 'a//b', 'a/', '/', '~', '~/', '~x', '{node}', 'é', 'a\nb', 'x' * 300),
    *('~/status', '/rosout'),
]


def _every_malformed_call_is_answered(cell: CellProcesses, client: WatchingClient) -> None:
    for name in BAD_NAMES:
        assert client.open(topic=name) == '', name
        assert not client.close_stream(name), name
        assert not client.reconfigure(name, parameters()), name
        assert not client.close_text(name), name
    assert not client.close_stream('')
    good = client.open()
    for period_s in (math.nan, -1.0, -math.inf):
        assert client.open(parameters(period_s)) == ''
        assert not client.reconfigure(good, parameters(period_s))
    texts = []
    for variable in ('', '.', '/', '..', 'a.b.c', 'é', '/small_cell/belt.__class__'):
        texts.append(client.open_text(variable))
        assert texts[-1], variable

    seen = client.watch(good)
    client.until(seen, lambda s: True, 'a snapshot in spite of all that')
    refused = cell.node.errors.count('snapshot_streams/open refused: ')
    assert refused == len(BAD_NAMES) + 3
    assert client.close_stream(good)
    assert all(map(client.close_text, texts))


def _too_many_streams_are_refused_with_an_answer(client: WatchingClient) -> None:
    topics = [client.open() for _ in range(STREAMS + 1)]
    assert [topic == '' for topic in topics] == [False] * STREAMS + [True]
    assert client.close_stream(topics[0])
    topics[0] = client.open()
    assert topics[0]
    assert all(map(client.close_stream, topics[:STREAMS]))


def _a_watcher_is_killed(client: WatchingClient) -> str:
    """Return the topic of its stream, which ends while the next steps are done."""
    watcher = WatcherProcess()
    try:
        topic = watcher.topic()
        client.ros.spin_until(lambda: client.ros.node.count_publishers(topic), 'its stream')
    finally:
        watcher.kill()
    return topic


def _a_topic_asked_for_by_name_is_shared(cell: CellProcesses, client: WatchingClient) -> None:
    base = '/bt_orchestrator'
    assert client.open(topic='mine') == f'{base}/snapshot_streams/mine'
    assert client.open(topic='~/mine') == f'{base}/mine'
    assert client.open(topic='/elsewhere/mine') == '/elsewhere/mine'
    seen = client.watch('/elsewhere/mine')
    client.until(seen, lambda s: True, 'the first')

    assert client.open(topic='/elsewhere/mine') == '/elsewhere/mine'
    assert client.open(parameters(1.0), '/elsewhere/mine') == '', 'watched with other parameters'
    assert client.close_stream('/elsewhere/mine')
    at_work(cell, 'WO-2')
    client.until(seen, lambda s: s.status(LONG_WORK) == Behaviour.RUNNING, 'still open')
    assert client.close_stream('/elsewhere/mine')
    client.until_gone('/elsewhere/mine', within_s=20.0)
    assert client.close_stream('mine')
    assert client.close_stream('~/mine')
    end_work(cell, 'WO-2')


def _a_subscriber_that_comes_late_misses_nothing(
    cell: CellProcesses, client: WatchingClient
) -> None:
    topics = [client.open(), client.open_text('/small_cell/cell')]
    at_work(cell, 'WO-3')
    client.ros.spin_for(2.0)

    snapshots, texts = client.watch(topics[0]), client.watch_text(topics[1])
    client.until(snapshots, lambda s: s.status(LONG_WORK) == Behaviour.RUNNING, 'at work')
    client.ros.spin_until(lambda: texts, 'the blackboard')
    assert '/small_cell/cell : Execute' in texts[0]
    assert client.close_stream(topics[0])
    assert client.close_text(topics[1])
    end_work(cell, 'WO-3')


def _the_blackboard_is_listed_and_followed(cell: CellProcesses, client: WatchingClient) -> None:
    names = client.variables()
    assert names == sorted(names)
    assert {'/small_cell/belt', '/small_cell/slots/2', '/small_cell/ready/worker'} <= set(names)

    topics = [client.open_text(), client.open_text('small_cell/slots/2', '/no/such.thing')]
    everything, part = map(client.watch_text, topics)
    client.ros.spin_until(lambda: everything and part, 'a first text')
    assert everything[0].startswith('Blackboard Data\n')
    assert all(f'    {name} ' in everything[0] for name in names)
    lines = [line.split() for line in part[0].splitlines()[1:]]
    assert lines == [['small_cell/slots/2', ':'], ['/no/such.thing', ':', '-']]

    at_work(cell, 'WO-4')
    client.ros.spin_until(lambda: any('slots/2 : WO-4/1' in text for text in part), 'the item')
    client.ros.spin_until(lambda: 'work of WO-4/1' in everything[-1], 'the work')
    assert all(map(client.close_text, topics))
    end_work(cell, 'WO-4')


def _the_blackboard_of_the_visited_path_with_what_is_done_there(
    cell: CellProcesses, client: WatchingClient
) -> None:
    topic = client.open_text(visited=True, activity=True)
    texts = client.watch_text(topic)
    client.ros.spin_until(lambda: texts, 'a first text')
    assert texts[0].splitlines()[:2] == ['Blackboard Data', '    - : -']

    at_work(cell, 'WO-5')
    client.ros.spin_until(
        lambda: '/small_cell/ready/worker : True' in texts[-1], 'the guard of the work'
    )
    assert not any('slots/2 :' in text.partition('Activity')[0] for text in texts)
    done = '\n'.join(text.partition('Blackboard Activity\n')[2] for text in texts)
    assert re.search(r'small_cell/belt +: WRITE .* at rest -> moving$', done, re.MULTILINE), done
    assert client.close_text(topic)
    assert not client.close_text(topic)
    client.until_gone(topic, within_s=20.0)
    end_work(cell, 'WO-5')


def _the_stream_of_a_killed_watcher_ends_and_the_cell_goes_on(
    cell: CellProcesses, client: WatchingClient, topic: str
) -> None:
    cell.run_small(task='TASK_C', quantity=3, order='WO-6')

    client.until_gone(topic, LEASE_S)
    assert cell.watch.until_ended('WO-6').packed == 3
    assert client.close_stream(topic) is False


# --- cells of their own: tasks that end when a test says so, faults, options --------------------


class Hands:
    """Controllers of the small cell whose tasks go on until the test lets them end.

    So each state lasts until it was seen: what is over before the next snapshot may be skipped.
    """

    def __init__(self, *names: str) -> None:
        self._done = {name: threading.Event() for name in names}
        self._servers = ThreadServers()
        for name in names:
            self._servers.serve(f'/{name}/task', Component, partial(self._work, name))

    def finish(self, *names: str) -> None:
        """Let controllers succeed with their tasks."""
        for name in names:
            self._done[name].set()

    def close(self) -> None:
        """Leave ROS, also in the middle of a task."""
        self.finish(*self._done)
        self._servers.close()

    def _work(self, name: str, goal: Any) -> Any:
        self._done[name].wait()
        goal.succeed()
        return Component.Result(task_result=True)


@pytest.fixture
def hands() -> Iterator[Hands]:
    hands = Hands('feeder', 'worker', 'packer')
    yield hands
    hands.close()


def test_inspection_shows_job_from_start_to_end(
    start_cell: StartCell, client: WatchingClient, hands: Hands
) -> None:
    cell = start_cell(STATELESS_CELL, shares=['conveyor'])
    cell.connect()
    seen = client.watch(client.open())
    idle = client.until(seen, lambda s: True, 'of the idle cell')
    assert idle.message.changed
    assert idle.text('next cycle').startswith('the cell is ')
    assert 'WO-1' not in idle.by_name
    new, running, done = Behaviour.INVALID, Behaviour.RUNNING, Behaviour.SUCCESS

    cell.run_small()
    client.until(seen, lambda s: s.status('feed (TASK_A)') == running, 'at the feeding')
    hands.finish('feeder')
    working = client.until(seen, lambda s: s.status(WORK) == running, 'at work')
    assert working.message.changed
    assert working.text(WORK) == 'running at worker/task'
    assert working.status('section 2') == running
    assert working.status('pack (TASK_A)') == new
    root = working.message.behaviours[0]
    assert (root.name, root.type, root.additional_detail) == ('small_cell', 4, 'OnAll')
    assert not working.message.blackboard_on_visited_path
    hands.finish('worker')
    client.until(seen, lambda s: s.status('pack (TASK_A)') == running, 'at the packing')
    hands.finish('packer')
    client.ros.spin_until(lambda: 'WO-1' not in seen[-1].by_name, 'the end of the job')

    statuses = [s.status(WORK) for s in seen if 'WO-1' in s.by_name]
    assert [status for status, _ in groupby(statuses)][:3] == [new, running, done]
    counts = [s.message.statistics.count for s in seen]
    assert counts == sorted(counts)
    cell.stop()


def test_what_is_done_on_the_blackboard_is_shown(
    start_cell: StartCell, client: WatchingClient
) -> None:
    cell = start_cell(fail=['conveyor.=hang'])  # the last snapshot stays the last
    cell.connect()
    seen = client.watch(client.open(parameters(ON_CHANGE_S, activity=True)))
    client.until(seen, lambda s: True, 'the first')
    cell.run_small()

    def writes(snapshot: Any) -> list[tuple[str, str]]:
        done = snapshot.message.blackboard_activity
        return [(i.key, i.current_value) for i in done if i.activity_type == 'WRITE']

    client.until(seen, lambda s: ('/small_cell/belt', 'moving') in writes(s), 'the belt to move')


def test_many_watch_at_once_and_each_leaves_alone(
    start_cell: StartCell, client: WatchingClient, hands: Hands
) -> None:
    cell = start_cell(STATELESS_CELL, shares=['conveyor'])
    cell.connect()
    topics = [client.open() for _ in range(3)]
    assert len(set(topics)) == 3
    all_seen = [client.watch(topic) for topic in topics]
    client.ros.spin_until(lambda: all(all_seen), 'a snapshot for everybody')

    assert client.close_stream(topics[0])
    assert not client.close_stream(topics[0])
    client.until_gone(topics[0], within_s=20.0)
    cell.run_small()
    hands.finish('feeder', 'packer')
    for seen in all_seen[1:]:
        client.until(seen, lambda s: s.status(WORK) == Behaviour.RUNNING, 'at work')
    assert not any(WORK in s.by_name for s in all_seen[0])
    hands.finish('worker')
    cell.watch.until_ended('WO-1')
    cell.stop()


def test_the_default_stream_is_opened_by_a_parameter(
    start_cell: StartCell, client: WatchingClient
) -> None:
    cell = start_cell(run_options=['--ros-args', '-p', 'default_snapshot_stream:=true'])
    cell.connect()
    seen = client.watch('/bt_orchestrator/snapshots')
    client.until(seen, lambda s: True, 'the first')
    assert not client.close_stream('/bt_orchestrator/snapshots'), 'it is of no watcher'

    assert set_parameter(cell, double('default_snapshot_period', -1.0)) is False
    assert set_parameter(cell, double('default_snapshot_period', 0.1)) is True
    client.ros.spin_until(lambda: len(seen) > 5, 'repeated snapshots')
    off = ParameterValue(type=ParameterType.PARAMETER_BOOL, bool_value=False)
    assert set_parameter(cell, Parameter(name='default_snapshot_stream', value=off)) is True
    client.until_gone('/bt_orchestrator/snapshots', within_s=20.0)
    cell.stop()


def double(name: str, value: float) -> Any:
    kind = ParameterType.PARAMETER_DOUBLE
    return Parameter(name=name, value=ParameterValue(type=kind, double_value=value))


def set_parameter(cell: CellProcesses, parameter: Any) -> bool:
    request = SetParameters.Request(parameters=[parameter])
    (result,) = cell.watch.call(SetParameters, 'set_parameters', request).results
    return bool(result.successful)
