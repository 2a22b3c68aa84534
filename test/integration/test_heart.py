"""When the engine settles."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import pytest

from bt_orchestrator.ros.executor import heart as heart_module
from bt_orchestrator.ros.executor.heart import AT_LEAST_S, Heart


class Timer:
    """Rings when it is told to, and counts how often it was put off."""

    def __init__(self) -> None:
        self.ring: Callable[[], None] = lambda: None
        self.put_off = 0

    def reset(self) -> None:
        self.put_off += 1


@pytest.fixture
def now_s(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """The steady clock: one number, to be changed."""
    now = [100.0]
    monkeypatch.setattr(time, 'monotonic', lambda: now[0])
    return now


@pytest.fixture
def timer(monkeypatch: pytest.MonkeyPatch) -> Timer:
    one = Timer()

    def made(_: object, __: float, ring: Callable[[], None]) -> Any:
        one.ring = ring
        return one

    monkeypatch.setattr(heart_module, 'steady_timer', made)
    return one


def test_a_settle_puts_the_next_ring_off_and_one_comes_each_second_all_the_same(
    timer: Timer, now_s: list[float]
) -> None:
    settles: list[float] = []
    heart = Heart(None, None)  # type: ignore[arg-type]
    heart.start(lambda: settles.append(now_s[0]), 10.0)
    timer.ring()
    before = timer.put_off
    heart.beat()
    assert timer.put_off == before + 1

    now_s[0] += AT_LEAST_S
    heart.beat()
    assert timer.put_off == before + 1, 'it has not rung for a second'
    timer.ring()
    heart.beat()
    assert timer.put_off > before + 1
    assert len(settles) == 5
