"""The contract of gateways, with real action servers in another process."""

from __future__ import annotations

from collections.abc import Sequence

from contract.gateway_bench import Bench
from contract.gateway_contract import GatewayContract
from ros_bench import DISCOVERY_S, RosBench

from bt_orchestrator.model.cell import Component
from bt_orchestrator.model.fault import FaultKind


class TestRosGateway(GatewayContract):
    @staticmethod
    def make_bench(components: Sequence[Component]) -> Bench:
        return running_bench(components)


def running_bench(components: Sequence[Component]) -> RosBench:
    """Return a bench whose servers were discovered, except those that are told to be absent."""
    bench = RosBench(components)
    present = [c.name for c in components if all(f.kind is not FaultKind.ABSENT for f in c.faults)]
    bench.run_until(
        lambda: all(bench.gateway.available(name) for name in present), 'all servers', DISCOVERY_S
    )
    return bench
