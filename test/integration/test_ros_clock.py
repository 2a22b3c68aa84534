"""Deadlines on the clock of a node."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import rclpy
from rclpy.clock_type import ClockType
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock as ClockMessage

from bt_orchestrator.ros.clock import RosClock

pytestmark = pytest.mark.every_distro


class World:
    """A node that spins in the caller's thread."""

    def __init__(self, **options: Any) -> None:
        self._context = Context()
        rclpy.init(context=self._context)
        self.node = Node('clock_test', context=self._context, **options)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self.clock = RosClock(self.node)
        self.called: list[str] = []

    def note(self, name: str) -> Callable[[], None]:
        return lambda: self.called.append(name)

    def spin_until(self, condition: Callable[[], Any], within_s: float = 60.0) -> bool:
        deadline = time.monotonic() + within_s
        while not condition() and time.monotonic() < deadline:
            self._executor.spin_once(timeout_sec=0.05)
        return bool(condition())

    def close(self) -> None:
        self.clock.close()
        self._executor.shutdown()
        self.node.destroy_node()
        self._context.shutdown()


@pytest.fixture
def world() -> Iterator[World]:
    world = World()
    yield world
    world.close()


def test_now_is_the_time_of_day(world: World) -> None:
    assert world.clock.now() == pytest.approx(time.time(), abs=1.0)


def test_error_in_a_callback_stops_nothing(world: World) -> None:
    def fail() -> None:
        raise RuntimeError('meant to fail')

    world.clock.call_at(world.clock.steady() + 0.05, fail)
    world.clock.call_at(world.clock.steady() + 0.05, world.note('other'))
    assert world.spin_until(lambda: world.called == ['other'])


@pytest.mark.parametrize('step_s', [3600.0, -3600.0])
def test_setting_the_wall_clock_moves_no_deadline(
    world: World, monkeypatch: pytest.MonkeyPatch, step_s: float
) -> None:
    """The clock of the whole machine cannot be set here, so what the node reads is."""
    world.clock.call_at(world.clock.steady() + 0.3, world.note('soon'))
    world.clock.call_at(world.clock.steady() + 3000.0, world.note('never'))
    wall = time.time
    monkeypatch.setattr(time, 'time', lambda: wall() + step_s)
    assert world.clock.now() == pytest.approx(wall() + step_s, abs=1.0)
    assert world.spin_until(lambda: world.called)
    assert world.called == ['soon']


def test_deadline_timer_uses_the_steady_clock(world: World) -> None:
    (timer,) = world.node.timers
    assert timer.clock.clock_type is ClockType.STEADY_TIME


def test_the_uptime_is_that_of_the_machine(world: World) -> None:
    uptime = world.clock.uptime()
    assert uptime is not None
    assert uptime.boot == Path('/proc/sys/kernel/random/boot_id').read_text().strip()
    assert uptime.seconds == pytest.approx(time.clock_gettime(time.CLOCK_BOOTTIME), abs=5.0)


def test_one_timer_for_all(world: World) -> None:
    before = len(list(world.node.timers))
    for number in range(100):
        world.clock.call_at(world.clock.steady() + 3600.0 - number, world.note('never'))
    assert len(list(world.node.timers)) == before


def test_follows_simulated_time() -> None:
    world = World(parameter_overrides=[Parameter('use_sim_time', value=True)])
    try:
        clock = world.node.create_publisher(ClockMessage, '/clock', 10)

        def set_time(seconds: int) -> Callable[[], bool]:
            message = ClockMessage()
            message.clock.sec = seconds

            def is_set() -> bool:
                clock.publish(message)
                return world.clock.now() >= seconds

            return is_set

        assert world.spin_until(set_time(100))
        assert world.clock.uptime() is None
        world.clock.call_at(150.0, world.note('done'))
        assert not world.spin_until(lambda: world.called, within_s=0.5)
        assert world.spin_until(set_time(149))
        assert world.called == []
        advance = set_time(151)
        assert world.spin_until(lambda: advance() and world.called)
    finally:
        world.close()
