"""The contract of gateways, in virtual time."""

from __future__ import annotations

from collections.abc import Callable, Sequence, Sized
from typing import Any

from contract.gateway_bench import SERVER_TIMEOUT_S, Bench, cell_of
from contract.gateway_contract import GatewayContract
from fakes.action_types import FakeActionTypes

from bt_orchestrator.base.deadlines import has_come
from bt_orchestrator.model.cell import Component
from bt_orchestrator.sim.gateway import VirtualClock, VirtualGateway


class VirtualBench:
    """A virtual gateway; time passes only in `run_until` and `run_for`."""

    def __init__(self, components: Sequence[Component]) -> None:
        self.clock = VirtualClock()
        self.gateway = VirtualGateway(
            cell_of(components), FakeActionTypes(), self.clock, server_timeout_s=SERVER_TIMEOUT_S
        )

    @property
    def now(self) -> float:
        return self.clock.now()

    def run_until(self, condition: Callable[[], Any], what: str, within_s: float = 20.0) -> None:
        until = self.now + within_s
        while not condition():
            assert self.clock.advance(), f'nothing more happens, and no {what}'
            assert self.now <= until, f'waited {within_s} s for {what}'

    def run_for(self, seconds: float) -> None:
        until = self.now + seconds
        self.clock.call_at(until, lambda: None)
        while not has_come(until, self.now):
            assert self.clock.advance()

    def run_to_settle(self, woken: Sized, within_s: float) -> None:
        until = self.now + within_s
        assert self.clock.advance(), 'no clock moves, so no engine settles'
        assert self.now <= until, f'an engine would settle only at {self.now:g} s'

    def close(self) -> None:
        pass


class TestVirtualGateway(GatewayContract):
    @staticmethod
    def make_bench(components: Sequence[Component]) -> Bench:
        return VirtualBench(components)
