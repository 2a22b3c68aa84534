"""The contract of gateways, with real action servers in another process."""

from __future__ import annotations

import importlib.util
from collections.abc import Sequence

import pytest
from contract.gateway_bench import Bench
from contract.gateway_contract import GatewayContract
from rclpy.context import Context
from rclpy.executors import Executor
from ros_bench import running_bench

from bt_orchestrator.model.cell import Component

pytestmark = pytest.mark.every_distro

HAS_EVENTS_EXECUTOR = importlib.util.find_spec('rclpy.experimental') is not None


class TestRosGateway(GatewayContract):
    @staticmethod
    def make_bench(components: Sequence[Component]) -> Bench:
        return running_bench(components)


@pytest.mark.skipif(not HAS_EVENTS_EXECUTOR, reason='this rclpy has no events executor')
class TestRosGatewayOnEventsExecutor(GatewayContract):
    @staticmethod
    def make_bench(components: Sequence[Component]) -> Bench:
        return running_bench(components, make_executor=_events_executor)


def _events_executor(context: Context) -> Executor:
    from rclpy.experimental.events_executor import EventsExecutor

    executor: Executor = EventsExecutor(context=context)
    return executor
