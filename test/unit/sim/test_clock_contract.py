"""The contract of clocks, in virtual time."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from contract.clock_contract import ClockBench, ClockContract

from bt_orchestrator.sim.gateway import VirtualClock


class _VirtualBench:
    def __init__(self) -> None:
        self.clock = VirtualClock()

    def run_until(self, condition: Callable[[], Any]) -> None:
        while not condition():
            assert self.clock.advance(), 'nothing more happens'

    def run_for(self, seconds: float) -> None:
        passed: list[bool] = []
        self.clock.call_at(self.clock.steady() + seconds, lambda: passed.append(True))
        self.run_until(lambda: passed)

    def close(self) -> None:
        pass


class TestVirtualClock(ClockContract):
    @staticmethod
    def make_bench() -> ClockBench:
        return _VirtualBench()
