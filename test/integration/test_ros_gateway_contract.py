"""The contract of gateways, with real action servers in another process."""

from __future__ import annotations

from collections.abc import Sequence

from contract.gateway_bench import Bench
from contract.gateway_contract import GatewayContract
from ros_bench import running_bench

from bt_orchestrator.model.cell import Component


class TestRosGateway(GatewayContract):
    @staticmethod
    def make_bench(components: Sequence[Component]) -> Bench:
        return running_bench(components)
