"""The tree node in this process: whatever raises in a callback, it goes on."""

from __future__ import annotations

import importlib.util
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest
import rclpy
from bt_orchestrator_interfaces.srv import RemoveItem
from cell_processes import SMALL_CELL
from patience import PATIENCE_S
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.msg import ParameterValue
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.clock_type import ClockType
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions

from bt_orchestrator.base.stop_signals import StopSignals
from bt_orchestrator.cli.bootstrap import (
    build_bookkeeping,
    build_foresight,
    build_generating,
    build_stop_search,
    memory_store,
)
from bt_orchestrator.cli.journal_file import open_journal, open_standby
from bt_orchestrator.model.events import Event
from bt_orchestrator.ros.executor.alarms import steady_timer
from bt_orchestrator.ros.node import NODE_NAME, Parts, TreeNode
from bt_orchestrator.ros.node_parameters import NodeParameters
from bt_orchestrator.ros.services.outputs import StatusTopic

pytestmark = pytest.mark.every_distro


EXECUTORS = ['single']
if importlib.util.find_spec('rclpy.experimental') is not None:
    EXECUTORS.append('events')


LOOK_S = 0.02
"""How often `StopWhen` is asked, where nothing happens."""


class StopWhen(StopSignals):
    """Asks the node to stop as soon as a condition holds; fails if it never does."""

    def __init__(self, condition: Callable[[], object]) -> None:
        super().__init__()
        self._condition = condition
        self._deadline = time.monotonic() + PATIENCE_S

    @property
    def requested(self) -> bool:
        assert time.monotonic() < self._deadline, 'the node goes on, but nothing happens'
        return bool(self._condition())


class Failing:
    """A callback that raises as often as it is called."""

    def __init__(self) -> None:
        self.calls = 0

    def __call__(self, *_: object) -> Any:
        self.calls += 1
        raise RuntimeError('broken on purpose')


class Kept:
    """An output: it is told of an event as soon as that is kept."""

    seq = 0

    def publish(self, events: Sequence[Event]) -> None:
        self.seq = events[-1].seq


@pytest.fixture(params=EXECUTORS)
def tree_node(tmp_path: Path, request: pytest.FixtureRequest) -> Iterator[TreeNode]:
    """Give a tree node of the small cell, which does not run yet."""
    cell = tmp_path / 'cell.yaml'
    cell.write_text(SMALL_CELL)
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    parameters = NodeParameters(
        cell=cell,
        trees=(tmp_path,),
        tick_rate_hz=50.0,
        executor=request.param,
        server_timeout=1.0,
    )
    making = (build_foresight, build_bookkeeping, build_generating, build_stop_search)
    parts = Parts(open_journal, open_standby, memory_store, *making)
    node = TreeNode(Node(NODE_NAME), parameters, parts, StopSignals(), print)
    steady_timer(node.node, LOOK_S, lambda: None)
    yield node
    node.close()
    rclpy.try_shutdown()


def ask(tree_node: TreeNode) -> Any:
    """Let the node ask itself for the removal of an item, and return the response."""
    return answer(
        tree_node, RemoveItem, 'remove_item', RemoveItem.Request(item='WO-1/1', reason='a test')
    )


def answer(tree_node: TreeNode, kind: Any, service: str, request: Any) -> Any:
    """Let the node ask itself, and return the response."""
    client: Any = tree_node.node.create_client(kind, f'~/{service}')
    tree_node.serve(StopWhen(client.service_is_ready))
    future = client.call_async(request)
    tree_node.serve(StopWhen(future.done))
    return future.result()


def test_no_timer_goes_by_the_wall_clock(tree_node: TreeNode) -> None:
    tree_node.serve(StopWhen(lambda: True))
    kinds = {timer.clock.clock_type for timer in tree_node.node.timers}
    assert kinds == {ClockType.STEADY_TIME}


def test_2_4_running_node_refuses_clock_and_parameter_changes(tree_node: TreeNode) -> None:
    node = tree_node.node
    [result] = node.set_parameters([Parameter('use_sim_time', value=True)])
    assert not result.successful
    assert result.reason == (
        'use_sim_time is read when the node starts and cannot be changed while it runs; start it '
        'anew with --ros-args -p use_sim_time:=true, or without it'
    )
    assert not node.get_clock().ros_time_is_active  # type: ignore[attr-defined]
    assert not node.get_subscriptions_info_by_topic('/clock'), 'nobody listens to a clock'
    names = set(node.list_parameters([], 0).names) - {'use_sim_time'}
    changeable = {n for n in names if not node.describe_parameter(n).read_only}
    assert {n for n in changeable if not n.startswith('default_snapshot_')} == set(), (
        'watchers only'
    )


def test_parameter_of_unknown_type_is_refused(tree_node: TreeNode) -> None:
    strange = ParameterMessage(name='cell', value=ParameterValue(type=255))
    known = Parameter('executor', value='single').to_parameter_msg()
    both = [strange, known]

    each = answer(
        tree_node, SetParameters, 'set_parameters', SetParameters.Request(parameters=both)
    )
    assert [outcome.successful for outcome in each.results] == [False, False]
    why = each.results[0].reason
    assert why == (
        'cell has a value of type 255; expected one of rcl_interfaces/msg/ParameterType, 0 to 9'
    )
    assert 'read-only' in each.results[1].reason

    kind = SetParametersAtomically
    together = answer(
        tree_node, kind, 'set_parameters_atomically', kind.Request(parameters=both[::-1])
    )
    assert together.result.reason == why


def test_an_unknown_parameter_is_refused_with_the_nearest(tree_node: TreeNode) -> None:
    wrong = [Parameter(name, value=5.0).to_parameter_msg() for name in ('tick_rate', 'zzz')]
    each = answer(
        tree_node, SetParameters, 'set_parameters', SetParameters.Request(parameters=wrong)
    )
    near, unlike = (outcome.reason for outcome in each.results)
    assert near == "there is no parameter 'tick_rate'; did you mean `tick_rate_hz`?"
    assert unlike.startswith("there is no parameter 'zzz'; the parameters are auto_resume, ")
    kind = SetParametersAtomically
    together = answer(tree_node, kind, 'set_parameters_atomically', kind.Request(parameters=wrong))
    assert together.result.reason == near


def test_raising_callback_does_not_stop_node(tree_node: TreeNode) -> None:
    failing = Failing()
    tree_node.node.create_timer(0.02, failing)
    tree_node.serve(StopWhen(lambda: failing.calls >= 3))

    assert 'nothing' in ask(tree_node).message


def test_raising_settle_is_counted_and_retried(
    tree_node: TreeNode, monkeypatch: pytest.MonkeyPatch
) -> None:
    failing = Failing()
    with monkeypatch.context() as patch:
        patch.setattr(tree_node.orchestrator, 'settle', failing)
        tree_node.serve(StopWhen(lambda: tree_node.heart.failures >= 3))
    assert failing.calls == tree_node.heart.failures

    assert 'nothing' in ask(tree_node).message


def test_node_at_rest_settles_once_a_second(
    tree_node: TreeNode, monkeypatch: pytest.MonkeyPatch
) -> None:
    settles = 0

    def nothing_happens() -> bool:
        nonlocal settles
        settles += 1
        return False

    monkeypatch.setattr(tree_node.orchestrator, 'settle', nothing_happens)
    over = time.monotonic() + 3.0
    tree_node.serve(StopWhen(lambda: time.monotonic() >= over))
    assert 2 <= settles <= 10, 'three of the pulse, and not fifty a second'


def test_first_status_shows_only_durable_events(
    tree_node: TreeNode, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = Kept()
    tree_node.orchestrator.add_sink(kept)
    published: list[tuple[int, int]] = []

    def tell(_: StatusTopic) -> None:
        published.append((tree_node.orchestrator.state.seq, kept.seq))

    monkeypatch.setattr(StatusTopic, 'publish_now', tell)
    tree_node.serve(StopWhen(lambda: published))
    (shown, durable) = published[0]
    assert 0 < shown <= durable


def test_a_service_that_raises_answers_so(
    tree_node: TreeNode, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patch:
        patch.setattr(tree_node.orchestrator, 'carry_out', Failing())
        response = ask(tree_node)
    assert not response.accepted
    assert 'internal error' in response.message
    assert 'broken on purpose' in response.message

    assert 'nothing' in ask(tree_node).message
