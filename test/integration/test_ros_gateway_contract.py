"""The contract of gateways, with real action servers in another process."""

from __future__ import annotations

import importlib.util
from collections.abc import Sequence

import pytest
from contract.gateway_bench import Bench
from contract.gateway_contract import GatewayContract
from ros_bench import running_bench

from bt_orchestrator.model.cell import Component
from bt_orchestrator.ros.node_parameters import EVENTS, PLAIN

pytestmark = pytest.mark.every_distro

HAS_EVENTS_EXECUTOR = importlib.util.find_spec('rclpy.experimental') is not None


class TestRosGateway(GatewayContract):
    @staticmethod
    def make_bench(components: Sequence[Component]) -> Bench:
        return running_bench(components)


class TestPlainRosGateway(GatewayContract):
    @staticmethod
    def make_bench(components: Sequence[Component]) -> Bench:
        return running_bench(components, client=PLAIN)


@pytest.mark.skipif(not HAS_EVENTS_EXECUTOR, reason='this rclpy has no events executor')
class TestRosGatewayOnEventsExecutor(GatewayContract):
    @staticmethod
    def make_bench(components: Sequence[Component]) -> Bench:
        return running_bench(components, kind=EVENTS)


@pytest.mark.skipif(not HAS_EVENTS_EXECUTOR, reason='this rclpy has no events executor')
class TestPlainRosGatewayOnEventsExecutor(GatewayContract):
    @staticmethod
    def make_bench(components: Sequence[Component]) -> Bench:
        return running_bench(components, kind=EVENTS, client=PLAIN)
