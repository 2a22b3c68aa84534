"""What the ROS gateway does beyond the contract of all gateways."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator, Sequence, Sized
from typing import Any

import pytest
from action_msgs.msg import GoalStatus as ActionStatus
from contract.gateway_bench import component, goal_request
from rclpy.action.graph import get_action_client_names_and_types_by_node
from ros_bench import RosBench, running_bench
from thread_servers import LateYes, ThreadServers

from bt_orchestrator.model.cell import Component
from bt_orchestrator.model.goal import RESULT_CHECK_S, SERVER_LEASE_S, GoalStatus, SeenContest
from bt_orchestrator.ros.actions.action_link import ActionLink
from bt_orchestrator.ros.actions.open_goals import RosGoal

pytestmark = pytest.mark.every_distro

PLAIN = (
    Component('fibonacci', (1,), '/fibonacci', 'test_msgs/action/Fibonacci'),
    Component('nested', (1,), '/nested', 'test_msgs/action/NestedMessage'),
    component('slow'),
)


@pytest.fixture
def bench() -> Iterator[RosBench]:
    """Return a bench without simulated servers."""
    bench = RosBench(PLAIN, serve=False)
    yield bench
    bench.close()


@pytest.fixture
def cell() -> Iterator[RosBench]:
    """Return a bench with simulated servers."""
    bench = running_bench([component('good', task_s=0.05), component('hanging', '#*=hang')])
    yield bench
    bench.close()


def link(bench: RosBench, name: str) -> ActionLink:
    return bench.gateway._links[name]


def client(bench: RosBench, name: str) -> Any:
    """Return the client, whose parts are of the lean way."""
    return link(bench, name)._client


def ended(bench: RosBench, goal: RosGoal, within_s: float = 60.0) -> GoalStatus:
    bench.run_until(lambda: goal.end is not None, f'the end of {goal}', within_s)
    assert goal.end is not None
    return goal.end.status


class TestAnyActionType:
    def test_name_and_type_are_enough(self, bench: RosBench, servers: ThreadServers) -> None:
        from test_msgs.action import Fibonacci

        servers.serve('/fibonacci', Fibonacci, fibonacci)
        for _ in range(20):
            goal = bench.gateway.send(goal_request('fibonacci', 'any label', order=5))
            assert ended(bench, goal) is GoalStatus.SUCCEEDED
            assert goal.end is not None
            assert goal.end.result == {'sequence': [0, 1, 1, 2, 3, 5]}
            if goal.feedback is not None:
                break  # that of the first goals may leave before the topics have found each other
        assert goal.feedback is not None
        assert goal.feedback == {'sequence': [0, 1, 1, 2, 3, 5]}

    def test_nested_goal_fields(self, bench: RosBench, servers: ThreadServers) -> None:
        from test_msgs.action import NestedMessage

        servers.serve('/nested', NestedMessage, echo_nested)
        args = {
            'nested_field': {'int32_value': -7, 'float64_value': 2, 'byte_value': 200},
            'nested_different_pkg': {'sec': 3},
        }
        goal = bench.gateway.send(goal_request('nested', '', **args))
        assert ended(bench, goal) is GoalStatus.SUCCEEDED
        assert goal.end is not None
        nested = goal.end.result['nested_field']
        assert (nested['int32_value'], nested['float64_value']) == (-7, 2.0)
        assert nested['byte_value'] == 200
        assert goal.end.result['nested_different_pkg'] == {'sec': 3, 'nanosec': 0}

    def test_goals_with_and_without_arguments_keep_their_own(
        self, bench: RosBench, servers: ThreadServers
    ) -> None:
        from test_msgs.action import NestedMessage

        servers.serve('/nested', NestedMessage, echo_nested)
        seen = []
        for args in ({}, {'nested_field': {'int32_value': -7}}, {}):
            goal = bench.gateway.send(goal_request('nested', '', **args))
            assert ended(bench, goal) is GoalStatus.SUCCEEDED
            assert goal.end is not None
            seen.append(goal.end.result['nested_field']['int32_value'])
        assert seen == [0, -7, 0]


class TestRequest:
    def test_the_server_sees_the_uuid_and_the_task(self, cell: RosBench) -> None:
        goal = cell.gateway.send(goal_request('good', 'TASK_B', special_argument_1='x'))
        assert ended(cell, goal) is GoalStatus.SUCCEEDED
        [record] = cell.server.records(event='accepted')
        assert (record['goal'], record['task']) == (goal.request.id, 'TASK_B')

    @pytest.mark.parametrize(
        ('task', 'args', 'message'),
        [
            ('TASK_A', {'special_argument_2': 'much'}, 'special_argument_2 must be a number'),
            ('TASK_A', {'special_argumnt': 1}, 'there is no field special_argumnt'),
            ('TASK_X', {}, 'has no task TASK_X'),
        ],
    )
    def test_what_does_not_fit_is_not_sent(
        self, cell: RosBench, task: str, args: dict[str, Any], message: str
    ) -> None:
        goal = cell.gateway.send(goal_request('good', task, **args))
        assert ended(cell, goal) is GoalStatus.REJECTED
        assert goal.end is not None
        assert message in goal.end.message
        assert cell.server.records(component='good', event='accepted') == []

    def test_rejection_by_busy_server_names_foreign_goal(self, cell: RosBench) -> None:
        another = cell.make_gateway()
        foreign = another.send(goal_request('hanging', 'TASK_B'))
        cell.run_until(lambda: foreign.accepted, 'the other client to be served')
        goal = cell.gateway.send(goal_request('hanging', 'TASK_A'))
        assert ended(cell, goal) is GoalStatus.REJECTED
        assert goal.end is not None
        assert goal.end.message == (
            f'refused by the server; it runs a goal of another client, {foreign.request.id}'
        )
        own = another.send(goal_request('hanging', 'TASK_A'))
        assert ended(cell, own) is GoalStatus.REJECTED
        assert own.end is not None
        assert own.end.message == 'refused by the server', 'it is busy with a goal of its own'
        another.close()

    # rclpy's own server uses a deprecated name when it does not know a goal.
    @pytest.mark.filterwarnings('ignore:Deprecated in favor of:DeprecationWarning')
    def test_late_yes_to_a_lost_request_is_cancelled(
        self, bench: RosBench, servers: ThreadServers
    ) -> None:
        from bt_orchestrator_interfaces.action import Component as Action

        yes = LateYes()
        cancelled = threading.Event()

        def execute(handle: Any) -> Any:
            given_up = time.monotonic() + 25.0
            while not handle.is_cancel_requested and time.monotonic() < given_up:
                cancelled.wait(0.01)
            if handle.is_cancel_requested:
                cancelled.set()
                handle.canceled()
            return Action.Result()

        servers.serve('/slow/task', Action, execute, yes.decide)
        lost = bench.gateway.send(goal_request('slow'))
        assert ended(bench, lost) is GoalStatus.LOST
        end = lost.end
        yes.say()
        bench.run_until(cancelled.is_set, 'the cancel request')
        assert lost.end is end
        assert not lost.accepted

    def test_goal_survives_lost_answer_to_its_request(self, cell: RosBench) -> None:
        lose_answers(client(cell, 'good'))
        goal = cell.gateway.send(goal_request('good', 'TASK_B'))
        assert ended(cell, goal) is GoalStatus.SUCCEEDED
        assert goal.accepted

    def test_status_topic_reveals_acceptance_with_lost_answer(self, cell: RosBench) -> None:
        lose_answers(client(cell, 'hanging'))
        goal = cell.gateway.send(goal_request('hanging'))
        cell.run_until(lambda: goal.accepted, 'the acceptance', RESULT_CHECK_S)
        goal.cancel()
        assert ended(cell, goal) is GoalStatus.CANCELED

    def test_cancel_without_the_answer_to_the_request(self, cell: RosBench) -> None:
        lose_answers(client(cell, 'hanging'))
        goal = cell.gateway.send(goal_request('hanging'))
        goal.cancel()
        assert ended(cell, goal) is GoalStatus.CANCELED


def test_the_graph_knows_it_as_an_action_client(bench: RosBench) -> None:
    node = bench.node

    def clients() -> set[str]:
        pairs = get_action_client_names_and_types_by_node(
            node, node.get_name(), node.get_namespace()
        )
        return {name for name, _ in pairs}

    bench.run_until(clients, 'the graph')
    assert clients() == {'/conveyor/index', '/fibonacci', '/nested', '/slow/task'}


class TestStatus:
    def test_status_and_feedback_are_kept_without_waking(self, cell: RosBench) -> None:
        goal = cell.gateway.send(goal_request('good', 'TASK_A'))
        assert ended(cell, goal) is GoalStatus.SUCCEEDED
        listening, sending = client(cell, 'good'), cell.make_gateway()
        takes = [counted(service, 'take') for service in listening._services]
        others = sending.send(goal_request('good', 'TASK_A'))
        assert ended(cell, others) is GoalStatus.SUCCEEDED
        cell.run_for(0.2)
        assert sum(taken() for taken in takes) <= 2  # answers reach every client of a service
        assert listening.status.of(others.id) == ActionStatus.STATUS_SUCCEEDED
        assert not listening.status.is_busy
        assert listening.feedback(others.id).current_sub_task.startswith('TASK_A')
        sending.close()


class TestKilledServer:
    @pytest.mark.long
    def test_that_stays_away_is_lost_after_its_lease(self, cell: RosBench) -> None:
        goal = cell.gateway.send(goal_request('hanging'))
        cell.run_until(lambda: goal.accepted, 'the acceptance')
        cell.kill_server()
        later = cell.gateway.send(goal_request('good'))
        assert ended(cell, goal, 3 * SERVER_LEASE_S) is GoalStatus.LOST
        assert ended(cell, later, 3 * SERVER_LEASE_S) is GoalStatus.LOST
        cell.run_until(lambda: not cell.gateway.available('good'), 'it to be gone')
        assert nothing_left(client(cell, 'hanging')) == {}

    def test_server_back_at_once_loses_the_goal(self, cell: RosBench) -> None:
        goal = cell.gateway.send(goal_request('hanging'))
        cell.run_until(lambda: goal.accepted, 'the acceptance')
        cell.kill_server()
        cell.start_server()
        assert ended(cell, goal, SERVER_LEASE_S - 5.0) is GoalStatus.LOST
        again = cell.gateway.send(goal_request('good'))
        assert ended(cell, again) is GoalStatus.SUCCEEDED

    @pytest.mark.long
    def test_long_lived_server_gets_new_id_after_restart(self, cell: RosBench) -> None:
        status = client(cell, 'good').status
        cell.run_until(lambda: status.publisher_id() and status._is_told, 'a graph at rest')
        before = status.publisher_id()
        cell.kill_server()
        cell.start_server()
        within_s = SERVER_LEASE_S + 5.0
        cell.run_until(lambda: status.publisher_id() not in (before, None), 'its id', within_s)


class TestBounds:
    def test_nothing_is_kept_of_goals_that_ended(self, cell: RosBench) -> None:
        for _ in range(60):
            goal = cell.gateway.send(goal_request('good', 'TASK_A'))
            assert ended(cell, goal) is GoalStatus.SUCCEEDED
        assert nothing_left(client(cell, 'good')) == {}

    def test_repeated_questions_are_forgotten_with_the_goal(self, cell: RosBench) -> None:
        goal = cell.gateway.send(goal_request('hanging'))
        cell.run_for(3 * RESULT_CHECK_S + 1.0)
        assert len(client(cell, 'hanging')._results) == 4
        goal.cancel()
        assert ended(cell, goal) is GoalStatus.CANCELED
        assert nothing_left(client(cell, 'hanging')) == {}

    def test_requests_without_answer_are_forgotten(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr('bt_orchestrator.ros.actions.open_goals._MOST_UNANSWERED', 3)
        bench = running_bench([component('mute', '#*=mute')])
        try:
            goals = [bench.gateway.send(goal_request('mute')) for _ in range(8)]
            for goal in goals:
                assert ended(bench, goal) is GoalStatus.LOST
            assert len(client(bench, 'mute')._goals) == 3
        finally:
            bench.close()


class TestErrors:
    def test_unreadable_result_ends_its_goal_and_no_other(
        self, cell: RosBench, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        def fail(message: Any) -> Any:
            raise RuntimeError('unreadable')

        with monkeypatch.context() as patch:
            patch.setattr('bt_orchestrator.ros.actions.goal_follower.to_plain', fail)
            goal = cell.gateway.send(goal_request('good'))
            assert ended(cell, goal) is GoalStatus.LOST
            assert goal.end is not None
            assert 'unreadable' in goal.end.message
        assert ended(cell, cell.gateway.send(goal_request('good'))) is GoalStatus.SUCCEEDED

    def test_resent_request_after_crash_is_not_rejected(self, cell: RosBench) -> None:
        goal = cell.gateway.send(goal_request('good', 'TASK_B'))
        cell.run_until(lambda: goal.accepted, 'the acceptance')
        again = cell.gateway.send(goal.request)
        assert ended(cell, again) is GoalStatus.SUCCEEDED
        assert ended(cell, goal) is GoalStatus.SUCCEEDED
        assert len(cell.server.records(event='started')) == 1


def test_close_leaves_the_node_usable() -> None:
    bench = RosBench([component('absent')], serve=False)
    bench.gateway.send(goal_request('absent'))
    bench.gateway.close()
    bench.run_for(0.5)
    bench.gateway = bench.make_gateway()
    assert ended(bench, bench.gateway.send(goal_request('absent'))) is GoalStatus.UNAVAILABLE
    bench.close()


def fibonacci(handle: Any) -> Any:
    from test_msgs.action import Fibonacci

    sequence = [0, 1]
    for _ in range(1, handle.request.order):
        sequence.append(sequence[-1] + sequence[-2])
    handle.publish_feedback(Fibonacci.Feedback(sequence=sequence))
    handle.succeed()
    return Fibonacci.Result(sequence=sequence)


def echo_nested(handle: Any) -> Any:
    from test_msgs.action import NestedMessage

    handle.succeed()
    goal = handle.request
    return NestedMessage.Result(
        nested_field=goal.nested_field, nested_different_pkg=goal.nested_different_pkg
    )


def counted(thing: Any, name: str) -> Callable[[], int]:
    """Let the calls of a method be counted from now on."""
    method, calls = getattr(thing, name), []

    def call(*arguments: Any) -> Any:
        calls.append(arguments)
        return method(*arguments)

    setattr(thing, name, call)
    return lambda: len(calls)


def lose_answers(client: Any) -> None:
    """Let the client lose the answers to goal requests, as was seen after a fresh start."""
    take: Callable[[], Sequence[Any]] = client._goals.take

    def take_none() -> Sequence[Any]:
        return take()[:0]

    client._goals.take = take_none


def nothing_left(client: Any) -> dict[str, Any]:
    """Return what the client still keeps of goals."""
    kept: dict[str, Sized] = {
        'requests': client._goals,
        'results': client._results,
        'cancels': client._cancels,
        'asked': client._asked,
    }
    return {name: each for name, each in kept.items() if len(each)}


class TestLeave:
    """Goals of a node that another one may have replaced (semantics 9.4)."""

    def test_9_4_a_goal_that_may_not_be_sent_waits(self, cell: RosBench) -> None:
        may_send: list[bool] = []
        cell.gateway.obey(lambda: bool(may_send), 0.0)
        goal = cell.gateway.send(goal_request('good'))
        cell.run_for(0.5)
        assert not goal.accepted
        assert goal.end is None
        may_send.append(True)
        assert ended(cell, goal) is GoalStatus.SUCCEEDED

    def test_9_4_a_cancel_waits_for_nobody(self, cell: RosBench) -> None:
        goal = cell.gateway.send(goal_request('hanging'))
        cell.run_until(lambda: goal.accepted, 'the acceptance')
        cell.gateway.obey(lambda: False, 0.0)
        goal.cancel()
        assert ended(cell, goal) is GoalStatus.CANCELED

    def test_9_4_cancel_withdraws_a_waiting_goal(self, cell: RosBench) -> None:
        cell.gateway.obey(lambda: False, 0.0)
        goal = cell.gateway.send(goal_request('good'))
        goal.cancel()
        assert goal.end is not None
        assert goal.end.never_begun

    def test_9_4_a_denial_counts_once_no_other_node_sends(self, cell: RosBench) -> None:
        begun = time.monotonic()
        alone_from_s = begun + RESULT_CHECK_S + 1.0
        cell.gateway.obey(lambda: True, alone_from_s)
        goal = cell.gateway.adopt(goal_request('good'))
        assert ended(cell, goal) is GoalStatus.LOST
        assert time.monotonic() >= alone_from_s, 'two denials came before that'
        assert goal.end is not None
        assert goal.end.denied_by is not None

    def test_9_4_what_came_while_another_node_led_is_forgotten(self, cell: RosBench) -> None:
        """A goal of the leader that has ended since is no unknown goal of its successor."""
        leader = cell.make_gateway()
        try:
            goal = leader.send(goal_request('hanging'))
            cell.run_until(lambda: goal.accepted, 'the acceptance')
            cell.run_until(lambda: goals_told(cell) == [(goal.request.id,)], 'the goal of another')
            cell.gateway.begin_anew()
            cell.run_until(lambda: goals_told(cell) == [(goal.request.id,)], 'it, once more')
            cell.gateway.begin_anew()
            goal.cancel()
            cell.run_until(lambda: goal.end is not None, 'its end')
            cell.run_for(1.5)  # the end is told as well
            cell.gateway.begin_anew()
            cell.run_for(1.5)
            assert goals_told(cell) == []
        finally:
            leader.close()


def goals_told(bench: RosBench) -> list[tuple[str, ...]]:
    """Return the goals of others that the gateway has told since the last time."""
    return [x.contest.goals for x in bench.gateway.drain() if isinstance(x, SeenContest)]
