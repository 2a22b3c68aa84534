"""The contract of clocks, on nodes that spin: on the steady clock and in simulated time."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import pytest
import rclpy
from contract.clock_contract import ClockBench, ClockContract
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock as ClockMessage

from bt_orchestrator.ports import Clock
from bt_orchestrator.ros.clock import RosClock
from bt_orchestrator.sim.controllers.node import NodeClock

pytestmark = pytest.mark.every_distro

WITHIN_S = 60.0


class _RosBench:
    """A node that spins in the caller's thread."""

    def __init__(self, make_clock: Callable[[Node], Clock], **options: Any) -> None:
        self._context = Context()
        rclpy.init(context=self._context)
        self.node = Node('clock_bench', context=self._context, **options)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self.clock = make_clock(self.node)

    def run_until(self, condition: Callable[[], Any]) -> None:
        deadline = time.monotonic() + WITHIN_S
        while not condition():
            assert time.monotonic() < deadline, f'not within {WITHIN_S:g} s'
            self.let_pass()
            self._executor.spin_once(timeout_sec=0.01)

    def run_for(self, seconds: float) -> None:
        until = self.clock.steady() + seconds
        self.run_until(lambda: self.clock.steady() >= until)

    def let_pass(self) -> None:
        """Do nothing: time passes by itself."""

    def close(self) -> None:
        self._executor.shutdown()
        self.node.destroy_node()
        self._context.shutdown()


class _SimulatedBench(_RosBench):
    """The same in simulated time, which goes on by 10 ms in every turn."""

    def __init__(self, make_clock: Callable[[Node], Clock]) -> None:
        simulated = [Parameter('use_sim_time', value=True)]
        super().__init__(make_clock, parameter_overrides=simulated)
        self._publisher = self.node.create_publisher(ClockMessage, '/clock', 10)
        self._turns = 0
        self.run_until(lambda: self.clock.now() > 0.0)

    def let_pass(self) -> None:
        self._turns += 1
        message = ClockMessage()
        seconds, hundredths = divmod(self._turns, 100)
        message.clock.sec = 1000 + seconds
        message.clock.nanosec = hundredths * 10_000_000
        self._publisher.publish(message)


class TestRosClock(ClockContract):
    @staticmethod
    def make_bench() -> ClockBench:
        return _RosBench(RosClock)


class TestRosClockInSimulatedTime(ClockContract):
    @staticmethod
    def make_bench() -> ClockBench:
        return _SimulatedBench(RosClock)


class TestNodeClock(ClockContract):
    @staticmethod
    def make_bench() -> ClockBench:
        return _RosBench(NodeClock)


class TestNodeClockInSimulatedTime(ClockContract):
    @staticmethod
    def make_bench() -> ClockBench:
        return _SimulatedBench(NodeClock)
