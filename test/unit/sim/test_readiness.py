"""What a simulated controller says about being ready."""

from __future__ import annotations

import pytest

from bt_orchestrator.model.fault import Fault, FaultKind
from bt_orchestrator.sim.controller import Readiness
from bt_orchestrator.sim.faults import FaultSchedule
from bt_orchestrator.sim.gateway import VirtualClock


class Bench:
    """A clock, and what was said when."""

    def __init__(self, *faults: Fault) -> None:
        self.clock = VirtualClock()
        self.said: list[tuple[float, bool]] = []
        self.readiness = Readiness(
            FaultSchedule(faults),
            lambda ready: self.said.append((self.clock.now(), ready)),
            lambda seconds, then: self.clock.call_at(self.clock.now() + seconds, then),
        )

    def run(self) -> list[tuple[float, bool]]:
        while self.clock.advance():
            pass
        return self.said


def not_ready(seconds: float | None) -> Fault:
    return Fault(FaultKind.NOT_READY, seconds=seconds)


@pytest.mark.parametrize(
    ('fault', 'steps'),
    [
        (None, [(0.0, True)]),
        (not_ready(2.0), [(0.0, False), (2.0, True)]),
        (not_ready(None), [(0.0, False)]),
    ],
)
def test_how_it_begins(fault: Fault | None, steps: list[tuple[float, bool]]) -> None:
    bench = Bench()
    bench.readiness.begin(fault)
    assert bench.run() == steps


def test_the_last_withdrawal_says_when_it_ends() -> None:
    bench = Bench()
    bench.readiness.withdraw(not_ready(2.0))
    bench.readiness.withdraw(not_ready(5.0))
    assert bench.run() == [(0.0, False), (0.0, False), (5.0, True)]


def test_a_silent_one_says_nothing() -> None:
    bench = Bench(Fault(FaultKind.SILENT, nth=0))
    bench.readiness.begin(None)
    bench.readiness.withdraw(not_ready(1.0))
    assert bench.run() == []
