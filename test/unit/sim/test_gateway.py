"""What the virtual gateway does beyond the contract: its times are exact."""

from __future__ import annotations

import pytest
from contract.gateway_bench import cell_of, component, goal_request
from fakes.action_types import FakeActionTypes

from bt_orchestrator.base.errors import UnknownActionType
from bt_orchestrator.model.cell import Component
from bt_orchestrator.model.goal import RESULT_TIMEOUT_S, GoalRequest, GoalStatus, StateReading
from bt_orchestrator.ports import Goal
from bt_orchestrator.sim.gateway import VirtualClock, VirtualGateway


class World:
    """One component, named arm, in virtual time."""

    def __init__(self, *faults: str, state: bool = False) -> None:
        self.clock = VirtualClock()
        cell = cell_of([component('arm', *faults, state=state)])
        self.gateway = VirtualGateway(cell, FakeActionTypes(), self.clock)

    def send(self, task: str = 'TASK_A') -> Goal:
        return self.gateway.send(goal_request('arm', task))

    def advance_to(self, time: float) -> None:
        self.clock.call_at(time, lambda: None)
        while self.clock.now() < time:
            assert self.clock.advance()

    def end(self, goal: Goal) -> tuple[GoalStatus, float]:
        """Return how a goal ends, and when."""
        while goal.end is None:
            assert self.clock.advance()
        return goal.end.status, self.clock.now()


@pytest.mark.parametrize(
    ('fault', 'status', 'time'),
    [
        ('#2=hang', GoalStatus.SUCCEEDED, 0.2),
        ('=late:1.5', GoalStatus.SUCCEEDED, 1.7),
        ('=reject', GoalStatus.REJECTED, 0.0),
        ('=abort', GoalStatus.ABORTED, 0.2),
        ('=cancel', GoalStatus.CANCELED, 0.2),
        ('=absent', GoalStatus.UNAVAILABLE, 5.0),
        ('=absent:2.5', GoalStatus.SUCCEEDED, 2.7),
        ('=mute', GoalStatus.LOST, 4.0),
        ('=die', GoalStatus.LOST, 20.1),
        ('=die:1.0', GoalStatus.LOST, 2.0),
        ('=die:1.9', GoalStatus.LOST, 2.0),
        ('=die:2.0', GoalStatus.LOST, 4.0),
        ('=die:19.0', GoalStatus.LOST, 20.0),
        ('=die:30', GoalStatus.LOST, 20.1),
    ],
)
def test_ends_when_the_ros_gateway_would_notice(
    fault: str, status: GoalStatus, time: float
) -> None:
    world = World(fault)
    assert world.end(world.send()) == (status, time)


def test_durations_may_be_drawn_instead() -> None:
    asked: list[GoalRequest] = []

    def draw(request: GoalRequest) -> float:
        asked.append(request)
        return 7.5

    clock = VirtualClock()
    cell = cell_of([component('arm')])
    gateway = VirtualGateway(cell, FakeActionTypes(), clock, duration=draw)
    goal = gateway.send(goal_request('arm'))
    while goal.end is None:
        clock.advance()
    assert clock.now() == 7.5
    assert asked == [goal.request]


def test_label_without_task_field_has_own_duration() -> None:
    plain = Component(
        'belt', (), '/belt', 'plain_interfaces/action/Index', durations_s={'A': 1.0, 'B': 3.0}
    )
    clock = VirtualClock()
    gateway = VirtualGateway(cell_of([plain]), FakeActionTypes(), clock)
    goal = gateway.send(goal_request('belt', 'B'))
    while goal.end is None:
        clock.advance()
    assert clock.now() == 3.0


def test_nothing_remains_armed_after_the_last_goal() -> None:
    world = World()
    world.end(world.send())
    assert world.clock.next_deadline() is None


def test_second_goal_of_a_busy_component_is_refused() -> None:
    world = World()
    first, second = world.send(), world.send()
    assert world.end(second) == (GoalStatus.REJECTED, 0.0)
    assert world.end(first) == (GoalStatus.SUCCEEDED, 0.2)


def test_request_to_dead_server_is_lost_on_return() -> None:
    world = World('=die:10')
    world.send()
    world.advance_to(1.0)
    assert world.gateway.available('arm')
    assert world.end(world.send()) == (GoalStatus.LOST, 1.0 + 10.0 + 2.0)


def test_request_to_dead_server_is_lost_with_lease() -> None:
    world = World('=die')
    world.send()
    world.advance_to(1.0)
    assert world.end(world.send()) == (GoalStatus.LOST, 20.1)
    assert world.end(world.send()) == (GoalStatus.UNAVAILABLE, 25.1)


def test_server_works_again_after_it_came_back() -> None:
    world = World('=die:30')
    world.end(world.send())
    world.advance_to(31.0)
    assert world.end(world.send()) == (GoalStatus.SUCCEEDED, 31.2)


def test_state_is_ready_before_the_first_drain() -> None:
    world = World(state=True)
    assert world.gateway.drain() == (StateReading('arm', 'READY'),)


def test_state_change_is_reported_before_goal_end() -> None:
    world = World('=not_ready:2.0', state=True)
    world.gateway.drain()
    goal = world.send()
    world.end(goal)
    assert world.gateway.drain() == (StateReading('arm', 'NOT_READY'), goal)
    world.clock.advance()
    assert world.clock.now() == 2.2
    assert world.gateway.drain() == (StateReading('arm', 'READY'),)


def test_state_of_an_absent_component_comes_with_it() -> None:
    world = World('=absent:3', state=True)
    assert world.gateway.drain() == ()
    world.clock.advance()
    assert world.gateway.drain() == (StateReading('arm', 'READY'),)


def test_state_of_dead_publisher_expires_with_lease() -> None:
    world = World('=die:30', state=True)
    world.end(world.send())
    assert world.gateway.drain()[-1] == StateReading('arm', None)
    world.advance_to(31.0)
    assert world.gateway.drain() == (StateReading('arm', 'READY'),)


def test_server_forgets_a_goal_after_its_result_timeout() -> None:
    world = World()
    goal = world.send()
    world.end(goal)
    world.advance_to(0.2 + RESULT_TIMEOUT_S + 0.1)
    world.end(world.send())
    assert world.end(world.gateway.adopt(goal.request))[0] is GoalStatus.LOST


def test_unknown_action_type_is_refused_at_once() -> None:
    with pytest.raises(UnknownActionType, match='bt_orchestrator_interfaces'):
        VirtualGateway(
            cell_of([]), FakeActionTypes(without='bt_orchestrator_interfaces'), VirtualClock()
        )
