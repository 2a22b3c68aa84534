"""Servers that are there and do not answer (semantics 9.3)."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from functools import partial
from typing import Any

import pytest
from contract.gateway_bench import component, goal_request
from mute_server import MuteServer
from rclpy.action.server import ActionServer
from ros_bench import RosBench, running_bench
from thread_servers import LateYes, ThreadServers

from bt_orchestrator.model.goal import GoalStatus
from bt_orchestrator.ros.actions.action_link import ActionLink
from bt_orchestrator.ros.actions.open_goals import RosGoal

pytestmark = pytest.mark.every_distro

CHECK_S = 0.25
SILENCE_S = 2.0
"""Long enough for a fresh participant to find the server, if the machine is not busy."""

PATIENCE_S = 30.0


@pytest.fixture(autouse=True)
def hurry(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr('bt_orchestrator.ros.actions.server_watch.RESULT_CHECK_S', CHECK_S)
    monkeypatch.setattr('bt_orchestrator.ros.actions.server_watch.SILENCE_S', SILENCE_S)


@pytest.fixture
def bench() -> Iterator[RosBench]:
    """Return a bench without simulated servers."""
    bench = RosBench([component('mute'), component('stubborn')], serve=False)
    yield bench
    bench.close()


@pytest.fixture
def cell() -> Iterator[RosBench]:
    """Return a bench with simulated servers."""
    bench = running_bench([component('good', task_s=1.0), component('other', task_s=1.0)])
    yield bench
    bench.close()


def test_9_3_ended_goal_without_result_is_in_doubt(
    bench: RosBench, servers: ThreadServers
) -> None:
    serve(servers, 'mute')
    goal = bench.gateway.send(goal_request('mute'))
    end = end_of(bench, goal)
    assert goal.accepted
    assert end.status is GoalStatus.SILENT
    assert end.topic_says == 'succeeded'


def test_9_3_unanswered_request_is_in_doubt_late_acceptance_cancelled(
    bench: RosBench, servers: ThreadServers
) -> None:
    yes = LateYes()
    cancelled = threading.Event()

    serve(servers, 'stubborn', until=cancelled, decide=yes.decide)
    goal = bench.gateway.send(goal_request('stubborn'))
    assert end_of(bench, goal).status is GoalStatus.SILENT
    yes.say()
    bench.run_until(cancelled.is_set, 'the cancel request')
    assert not goal.accepted


def test_9_2_adopted_goal_of_silent_server_is_in_doubt(
    bench: RosBench, servers: ThreadServers
) -> None:
    serve(servers, 'mute')
    goal = bench.gateway.adopt(goal_request('mute'))
    assert end_of(bench, goal).status is GoalStatus.SILENT
    assert not goal.accepted


@pytest.mark.filterwarnings('ignore:Deprecated in favor of:DeprecationWarning')
def test_9_2_forgotten_adopted_goal_is_lost_despite_status(
    bench: RosBench, servers: ThreadServers
) -> None:
    serve(servers, 'mute', kind=partial(ActionServer, result_timeout=0))
    goal = bench.gateway.send(goal_request('mute'))
    end_of(bench, goal)  # a success, unless it was forgotten before anybody could ask
    bench.run_for(1.0)
    adopted = bench.make_gateway().adopt(goal.request)
    end = end_of(bench, adopted)
    assert end.status is GoalStatus.LOST
    assert end.topic_says == 'succeeded'
    assert not adopted.accepted


def test_9_3_a_server_is_silent_while_a_goal_runs(bench: RosBench, servers: ThreadServers) -> None:
    ends = threading.Event()
    serve(servers, 'mute', until=ends)
    goal = bench.gateway.send(goal_request('mute'))
    bench.run_until(lambda: goal.accepted, 'the acceptance')
    adopted = bench.make_gateway().adopt(goal.request)
    bench.run_for(2.5 * SILENCE_S)
    assert goal.end is None
    assert adopted.accepted
    assert adopted.end is None
    assert link(bench, 'mute')._clients.may_be_renewed
    ends.set()


def test_9_3_a_client_that_has_gone_deaf_is_replaced(
    cell: RosBench, monkeypatch: pytest.MonkeyPatch
) -> None:
    goal = cell.gateway.send(goal_request('good'))
    other = cell.gateway.send(goal_request('other'))
    deafen(link(cell, 'good'))
    deafen(link(cell, 'other'))
    cell.run_until(lambda: goal.renewed and other.renewed, 'fresh participants')
    monkeypatch.setattr('bt_orchestrator.ros.actions.server_watch.SILENCE_S', PATIENCE_S)
    assert end_of(cell, goal).status is GoalStatus.SUCCEEDED
    assert goal.end is not None
    assert goal.end.result['measurement'] == 1.5
    assert end_of(cell, other).status is GoalStatus.SUCCEEDED
    again = cell.gateway.send(goal_request('good'))
    assert end_of(cell, again).status is GoalStatus.SUCCEEDED
    assert len(cell.server.records(event='started')) == 3
    [fresh] = cell.gateway._fresh._kept
    assert fresh.node.get_name() == '_bench_1'


def serve(
    servers: ThreadServers,
    name: str,
    until: threading.Event | None = None,
    **options: Any,
) -> None:
    """Serve an action mutely.

    :param until: goals end when it is set, or when they are cancelled; then it is set
    """
    from bt_orchestrator_interfaces.action import Component as Action

    def execute(handle: Any) -> Any:
        while until is not None and not handle.is_cancel_requested and not until.wait(0.01):
            pass
        if handle.is_cancel_requested:
            assert until is not None
            until.set()
            handle.canceled()
        else:
            handle.succeed()
        return Action.Result(task_result=True)

    servers.serve(f'/{name}/task', Action, execute, **{'kind': MuteServer, **options})


def deafen(link: ActionLink) -> None:
    """Let no answer reach the present client, as was seen after a crash of its predecessor."""

    def take_nothing() -> Any:
        return ()

    for service in link._clients.current._services:
        service.take = take_nothing  # type: ignore[attr-defined]


def link(bench: RosBench, name: str) -> ActionLink:
    return bench.gateway._links[name]


def end_of(bench: RosBench, goal: RosGoal) -> Any:
    bench.run_until(lambda: goal.end is not None, f'the end of {goal}', 30.0)
    return goal.end
