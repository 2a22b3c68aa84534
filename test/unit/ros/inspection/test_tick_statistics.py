"""How long ticks take and how often they come."""

from __future__ import annotations

import pytest

from bt_orchestrator.ros.inspection.snapshot_source import WINDOW, TickStatistics


class _Clock:
    """Stands still unless told otherwise."""

    def __init__(self) -> None:
        self.now = 50.0

    def __call__(self) -> float:
        return self.now

    def advance(self, seconds: float) -> None:
        self.now += seconds


def test_nothing_was_measured_before_the_first_tick() -> None:
    ticks = TickStatistics(_Clock())
    assert (ticks.count, ticks.duration, ticks.interval) == (0, (0, 0, 0), (0, 0, 0))


def test_durations_and_intervals_are_averaged() -> None:
    clock = _Clock()
    ticks = TickStatistics(clock)
    for duration_s, pause_s in ((1.0, 9.0), (3.0, 17.0), (2.0, 0.0)):
        ticks.timed(lambda d=duration_s: clock.advance(d))()  # type: ignore[misc]
        clock.advance(pause_s)

    assert ticks.count == 3
    assert ticks.duration == pytest.approx((2.0, 2.0, 2 / 3))
    assert ticks.interval == pytest.approx((20.0, 15.0, 25.0))


def test_a_tick_that_fails_counts_and_fails() -> None:
    clock = _Clock()
    ticks = TickStatistics(clock)

    def fail() -> None:
        clock.advance(4.0)
        raise KeyError('x')

    with pytest.raises(KeyError):
        ticks.timed(fail)()
    assert (ticks.count, ticks.duration.last) == (1, 4.0)


def test_old_ticks_are_forgotten() -> None:
    clock = _Clock()
    ticks = TickStatistics(clock)
    ticks.timed(lambda: clock.advance(1000.0))()
    for _ in range(WINDOW):
        ticks.timed(lambda: clock.advance(1.0))()
    assert ticks.duration == (1.0, 1.0, 0.0)


def test_the_variance_is_never_negative() -> None:
    clock = _Clock()
    ticks = TickStatistics(clock)
    for _ in range(WINDOW):
        ticks.timed(lambda: clock.advance(0.1))()
    assert ticks.duration.variance >= 0.0
