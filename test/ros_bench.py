"""The real gateway on a node of its own, and a simulated cell in another process."""

from __future__ import annotations

import json
import signal
import tempfile
import time
from collections.abc import Callable, Sequence, Sized
from pathlib import Path
from typing import Any

import rclpy
from contract.gateway_bench import SERVER_TIMEOUT_S, cell_of
from rclpy.context import Context
from rclpy.node import Node
from sim_cell_process import SimCellProcess

from bt_orchestrator.model.cell import Cell, Component
from bt_orchestrator.model.fault import EVERY, Fault, FaultKind
from bt_orchestrator.ros.actions.gateway import RosGateway
from bt_orchestrator.ros.executor.executors import make_executor
from bt_orchestrator.ros.executor.ways import choose_way
from bt_orchestrator.ros.node_parameters import AUTO, SINGLE
from bt_orchestrator.ros.types.action_types import InstalledActionTypes

DISCOVERY_S = 60.0


class RosBench:
    """A gateway whose callbacks run in `run_until` and `run_for`, in the caller's thread."""

    def __init__(
        self,
        components: Sequence[Component],
        kind: str = SINGLE,
        *,
        client: str = AUTO,
        serve: bool = True,
    ) -> None:
        self._directory = tempfile.TemporaryDirectory(prefix='bt_orchestrator_bench_')
        self.cell = cell_of(components)
        self._context = Context()
        rclpy.init(context=self._context)
        self.node = Node('bench', context=self._context)
        self._way = choose_way(client, self.node)
        self._executor = make_executor(kind, self._way, self._context)
        self._executor.add_node(self.node)
        self._server: SimCellProcess | None = None
        if serve:
            self.start_server()
        self.gateway = self.make_gateway()

    @property
    def now(self) -> float:
        return time.monotonic()

    def make_gateway(self) -> RosGateway:
        """Return a gateway on the bench's node."""
        return RosGateway(
            self.node,
            self.cell,
            InstalledActionTypes(),
            self._way,
            server_timeout_s=SERVER_TIMEOUT_S,
        )

    @property
    def node_time(self) -> float:
        """Seconds of the node's clock."""
        return float(self.node.get_clock().now().nanoseconds) / 1e9

    @property
    def server(self) -> SimCellProcess:
        """The other process."""
        assert self._server is not None
        return self._server

    def start_server(self) -> None:
        """Start the other process; the former one should have ended."""
        file = Path(self._directory.name, 'cell.yaml')
        file.write_text(cell_text(self.cell))
        names = [name for name in self.cell.components if name != 'conveyor']
        self._server = SimCellProcess(file, '--only', ','.join(names), *fault_options(self.cell))
        self._server.wait_ready()

    def run_until(self, condition: Callable[[], Any], what: str, within_s: float = 60.0) -> None:
        if not self._spin(within_s, condition):
            raise AssertionError(f'waited {within_s:.0f} s for {what}')

    def run_to_settle(self, woken: Sized, within_s: float) -> None:
        self.run_until(lambda: woken, 'a wake', within_s)

    def run_for(self, seconds: float) -> None:
        self._spin(seconds, lambda: False)

    def kill_server(self) -> None:
        """End the other process without a word to anybody."""
        self.server.stop(signal.SIGKILL)

    def close(self) -> None:
        self.gateway.close()
        self._executor.shutdown()
        self.node.destroy_node()
        self._context.shutdown()
        if self._server is not None:
            self._server.stop()
        self._directory.cleanup()

    def _spin(self, seconds: float, condition: Callable[[], Any]) -> bool:
        deadline = time.monotonic() + seconds
        while not condition():
            left_s = deadline - time.monotonic()
            if left_s <= 0:
                return False
            self._executor.spin_once(timeout_sec=min(left_s, 0.1))
        return True


def cell_text(cell: Cell) -> str:
    """Write a cell file; JSON is YAML too."""
    components = {n: _component(c) for n, c in cell.components.items() if n != 'conveyor'}
    belt = cell.conveyor.component
    conveyor = {
        'sections': cell.conveyor.sections,
        'action': belt.action,
        'type': belt.type,
        'task': cell.conveyor.task,
    }
    return json.dumps({'cell': cell.name, 'conveyor': conveyor, 'components': components})


def fault_options(cell: Cell) -> list[str]:
    """Write the faults of all components as options of sim-cell."""
    return [
        word
        for name, component in cell.components.items()
        for fault in component.faults
        for word in ('--fail', f'{name}.{_fault(fault)}')
    ]


def _component(component: Component) -> dict[str, Any]:
    state = component.state
    topic = {} if state is None else {'state': {**vars(state), 'ready': list(state.ready)}}
    setups = {name: list(setup.values) for name, setup in component.setups.items()}
    changes = {
        name: {'task': setup.task, 'argument': setup.argument, 'reads': setup.reads}
        for name, setup in component.setups.items()
    }
    return {
        'section': 1,
        'action': component.action,
        'type': component.type,
        'durations': dict(component.durations_s),
        'results': {task: dict(result) for task, result in component.results.items()},
        **topic,
        **({'setups': setups, 'changes': changes} if setups else {}),
    }


def _fault(fault: Fault) -> str:
    nth = '*' if fault.nth == EVERY else fault.nth
    seconds = '' if fault.seconds is None else f':{fault.seconds}'
    return f'{fault.task or ""}#{nth}={fault.kind.value}{seconds}'


def running_bench(components: Sequence[Component], **options: Any) -> RosBench:
    """Return a bench whose servers were discovered, except those that are told to be absent."""
    bench = RosBench(components, **options)
    present = [c.name for c in components if all(f.kind is not FaultKind.ABSENT for f in c.faults)]
    bench.run_until(
        lambda: all(bench.gateway.available(name) for name in present), 'all servers', DISCOVERY_S
    )
    return bench
