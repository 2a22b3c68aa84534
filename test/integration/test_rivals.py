"""Several servers of one action, as the gateway sees them (semantics 2.5 and 9.3)."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator
from functools import partial
from typing import Any

import pytest
import rclpy
from action_msgs.msg import GoalStatusArray
from bt_orchestrator_interfaces.action import Component as Action
from contract.gateway_bench import component, goal_request
from rclpy.action.server import ActionServer
from rclpy.context import Context
from rclpy.node import Node
from rclpy.qos import qos_profile_action_status_default
from ros_bench import RosBench
from thread_servers import ThreadServers

from bt_orchestrator.model.goal import RESULT_CHECK_S, Contest, GoalStatus, SeenContest
from bt_orchestrator.ros.actions import rivals
from bt_orchestrator.ros.actions.goal_client import GoalClient
from bt_orchestrator.ros.actions.open_goals import RosGoal


@pytest.fixture
def bench() -> Iterator[RosBench]:
    """Return a bench without simulated servers."""
    bench = RosBench([component('arm')], serve=False)
    yield bench
    bench.close()


@pytest.fixture
def second() -> Iterator[ThreadServers]:
    """Give servers in another context: another DDS participant."""
    servers = ThreadServers()
    yield servers
    servers.close()


def serve(
    servers: ThreadServers, until: threading.Event | None = None, remembered_s: int = 900
) -> list[bytes]:
    """Serve the arm; goals end at once, or when told. Return the goals, as they are executed.

    :param remembered_s: for how long after its end the server knows a goal
    """
    executed: list[bytes] = []

    def execute(handle: Any) -> Any:
        executed.append(bytes(handle.goal_id.uuid))
        while until is not None and not until.wait(0.01):
            pass
        handle.succeed()
        return Action.Result(task_result=True)

    kind = partial(ActionServer, result_timeout=remembered_s)
    servers.serve('/arm/task', Action, execute, kind=kind)
    return executed


def test_2_5_a_request_waits_while_there_are_two_servers(
    bench: RosBench, servers: ThreadServers, second: ThreadServers
) -> None:
    both = serve(servers), serve(second)
    # Their names take a moment; Jazzy does not learn them of nodes in its own process.
    bench.run_until(lambda: len(set(bench.gateway.rivals('arm'))) == 2, 'two servers')
    goal = bench.gateway.send(goal_request('arm'))
    assert end_of(bench, goal) is GoalStatus.UNAVAILABLE
    assert goal.end is not None
    assert goal.end.message.startswith('2 servers of /arm/task: ')
    assert both == ([], [])
    contests = [new for new in bench.gateway.drain() if isinstance(new, SeenContest)]
    assert {len(new.contest.servers) for new in contests} == {2}

    second.close_servers()
    bench.run_until(lambda: not bench.gateway.rivals('arm'), 'one server')
    again = bench.gateway.send(goal_request('arm'))
    assert end_of(bench, again) is GoalStatus.SUCCEEDED
    bench.run_until(lambda: SeenContest('arm', Contest()) in bench.gateway.drain(), 'to be told')


def test_2_5_server_without_status_counts_as_rival(
    bench: RosBench, servers: ThreadServers, second: ThreadServers
) -> None:
    serve(servers)
    service = Action.Impl.SendGoalService
    second.node.create_service(service, '/arm/task/_action/send_goal', lambda _, answer: answer)
    bench.run_until(lambda: bench.gateway.rivals('arm'), 'two servers')
    bench.run_until(
        lambda: (
            set(bench.gateway.rivals('arm'))
            & {
                '/thread_servers (publishes no status)',
                'one that publishes no status',
            }
        ),
        'words about it',
    )


def test_2_5_status_only_publisher_is_named_with_process(
    bench: RosBench, servers: ThreadServers
) -> None:
    serve(servers)
    bench.run_until(lambda: bench.gateway.available('arm'), 'the server')
    context = Context()
    rclpy.init(context=context)
    node = Node('intruder', context=context)
    try:
        node.create_publisher(
            GoalStatusArray, '/arm/task/_action/status', qos_profile_action_status_default
        )
        here = f'process {os.getpid()} on this computer'
        expected = {
            f'/intruder (publishes its status and takes no goals, {here})',
            f'/thread_servers ({here})',
        }
        bench.run_until(lambda: set(bench.gateway.rivals('arm')) == expected, 'words about it')
    finally:
        node.destroy_node()
        context.try_shutdown()


@pytest.mark.filterwarnings('ignore:Deprecated in favor of:DeprecationWarning')
def test_9_3_denial_by_second_server_does_not_lose_goal(
    bench: RosBench, servers: ThreadServers, second: ThreadServers
) -> None:
    ends = threading.Event()
    executed = serve(servers, until=ends)
    goal = bench.gateway.send(goal_request('arm'))
    bench.run_until(lambda: goal.accepted, 'the acceptance')
    serve(second)
    bench.run_until(lambda: bench.gateway.rivals('arm'), 'two servers')
    bench.run_for(5.0)  # two questions, which the second one answers with no
    assert goal.end is None
    adopted = bench.make_gateway().adopt(goal.request)
    bench.run_for(5.0)
    assert adopted.end is None
    ends.set()
    assert end_of(bench, goal) is GoalStatus.SUCCEEDED
    assert end_of(bench, adopted) is GoalStatus.SUCCEEDED
    assert len(executed) == 1


def test_9_3_second_server_refusal_hides_no_goal_end(
    bench: RosBench, servers: ThreadServers, second: ThreadServers
) -> None:
    ends = threading.Event()
    serve(servers, until=ends, remembered_s=0)  # it tells the end once, to all that have asked
    goal = bench.gateway.send(goal_request('arm'))
    bench.run_until(lambda: goal.accepted, 'the acceptance')
    serve(second)
    bench.run_until(lambda: bench.gateway.rivals('arm'), 'two servers')
    adopted = bench.make_gateway().adopt(goal.request)
    # Both have been asked, and the second one has answered, if it ever does.
    bench.run_for(2 * RESULT_CHECK_S)
    ends.set()
    assert end_of(bench, adopted) is GoalStatus.SUCCEEDED


def test_2_5_fresh_look_without_servers_decides_nothing(
    bench: RosBench, servers: ThreadServers, monkeypatch: pytest.MonkeyPatch
) -> None:
    # On a busy machine discovery takes longer than it should.
    serve(servers)
    bench.run_until(lambda: bench.gateway.available('arm'), 'the server')
    monkeypatch.setattr(rivals, 'DISCOVERY_S', 0.0)
    before: list[GoalClient] = []
    found_afresh = iter([0, 0])

    def count(client: GoalClient, node: object = None) -> int:
        if node is not None:
            return next(found_afresh, 1)
        before.append(client)
        return 2 if client is before[0] else 1  # a killed server, until it is renewed

    monkeypatch.setattr(GoalClient, 'count_servers', count)
    bench.run_until(lambda: bench.gateway.rivals('arm'), 'two servers')
    bench.run_until(lambda: not bench.gateway.rivals('arm'), 'one server')


def test_2_5_graph_is_searched_before_goal_not_before_decision(
    bench: RosBench, servers: ThreadServers, monkeypatch: pytest.MonkeyPatch
) -> None:
    serve(servers)
    bench.run_until(lambda: bench.gateway.available('arm'), 'the server')
    monkeypatch.setattr(rivals, 'LOOK_S', 0.0)  # the last look is too old
    looks: list[GoalClient] = []

    def count(client: GoalClient) -> int:
        looks.append(client)
        return 1

    monkeypatch.setattr(GoalClient, 'count_servers', count)
    assert not bench.gateway.rivals('arm')
    assert not looks
    bench.gateway.send(goal_request('arm'))
    assert len(looks) == 1
    prepared = goal_request('arm')
    bench.gateway.prepare(prepared)
    assert len(looks) == 2
    monkeypatch.setattr(rivals, 'LOOK_S', 60.0)  # it is young enough
    bench.gateway.send(prepared)
    assert len(looks) == 2


def end_of(bench: RosBench, goal: RosGoal) -> GoalStatus:
    bench.run_until(lambda: goal.end is not None, f'the end of {goal}', 30.0)
    assert goal.end is not None
    return goal.end.status
