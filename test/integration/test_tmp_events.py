from collections.abc import Sequence
from contract.gateway_contract import GatewayContract
from ros_bench import RosBench, DISCOVERY_S
from bt_orchestrator.model.fault import FaultKind
import time
from rclpy.experimental.events_executor import EventsExecutor
class TestE(GatewayContract):
    @staticmethod
    def make_bench(components):
        b = RosBench(components, lambda c: EventsExecutor(context=c))
        present=[c.name for c in components if all(f.kind is not FaultKind.ABSENT for f in c.faults)]
        b.run_until(lambda: all(b.gateway.available(n) for n in present),'servers',DISCOVERY_S)
        return b
