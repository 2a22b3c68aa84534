"""How often a node asks for a forecast: less often while it says the same, or takes long."""

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

    def __init__(self, took_s: float, later_s: float) -> None:
        """Answer at once.

        :param later_s: how much later than by the answer before the job ends
        """
        self.took_s = took_s
        self.asked = 0
        self._later_s = later_s

    @property
    def ends_s(self) -> Mapping[str, float]:
        return {'J': 50.0 + self.asked * self._later_s} if self.asked else {}

    def ask(self, state: str, observed_s: Mapping[str, Mapping[str, float]], now_s: float) -> None:
        self.asked += 1

    def close(self) -> None:
        """Have nothing to close."""


def asked_in_a_minute(took_s: float, monkeypatch: pytest.MonkeyPatch, later_s: float = 2.0) -> int:
    """Look once a second at a queue at work; return how often it was asked."""
    run, looks = Line().begin(THREE, 1000), list[Callable[[], None]]()
    foresight = Slow(took_s, later_s)
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


@pytest.mark.parametrize(
    ('later_s', 'asked'),
    [
        (0.0, 5),  # at 0, 5, 10, 20 and 40 s
        (0.9, 5),
        (-0.9, 5),
        (1.1, 12),
        (-1.1, 12),
    ],
)
def test_unchanged_forecast_is_made_less_often(
    later_s: float, asked: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert asked_in_a_minute(0.0, monkeypatch, later_s) == asked
