"""How often a node asks for a forecast: often, but never so that it keeps a processor busy."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import count
from types import SimpleNamespace
from typing import Any

import pytest
from fakes.line import THREE, Line

from bt_orchestrator.ros.services import expected_ends
from bt_orchestrator.ros.services.expected_ends import RENEW_S, RESTS, ExpectedEnds


class Slow:
    """Takes so long for each answer, and counts the questions. Implements `ports.Foresight`."""

    def __init__(self, took_s: float) -> None:
        self.took_s = took_s
        self.asked = 0
        self.ends_s: Mapping[str, float] = {}

    def ask(self, state: str, observed_s: Mapping[str, Mapping[str, float]], now_s: float) -> None:
        self.asked += 1

    def close(self) -> None:
        """Have nothing to close."""


def asked_in_a_minute(took_s: float, monkeypatch: pytest.MonkeyPatch) -> int:
    """Look once a second at a queue that goes on as expected; return how often it was asked."""
    run, foresight, looks = Line().begin(THREE, 1000), Slow(took_s), list[Callable[[], None]]()
    clock = SimpleNamespace(now=lambda: SimpleNamespace(nanoseconds=0))
    node: Any = SimpleNamespace(get_clock=lambda: clock)
    durations: Any = SimpleNamespace(kinds=1, seconds=dict)
    pulse: Any = SimpleNamespace(add=looks.append)
    engine: Any = run.sim.orchestrator
    steady = map(float, count(1000))
    monkeypatch.setattr(expected_ends, 'time', SimpleNamespace(monotonic=lambda: next(steady)))
    ExpectedEnds(node, engine, durations, foresight, pulse)
    for second in range(60):
        run.go(until=float(second))
        for look in looks:
            look()
    return foresight.asked


@pytest.mark.parametrize(
    ('took_s', 'every_s'), [(0.0, RENEW_S), (0.1, RENEW_S), (1.0, RESTS), (1.5, 1.5 * RESTS)]
)
def test_a_forecast_that_takes_long_is_made_seldom(
    took_s: float, every_s: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert asked_in_a_minute(took_s, monkeypatch) == 60 / every_s
