from __future__ import annotations

from bt_orchestrator.sim.gateway import VirtualClock


def test_clock_stays_at_zero_while_nothing_is_armed() -> None:
    clock = VirtualClock()
    assert clock.next_deadline() is None
    assert not clock.advance()
    assert clock.now() == 0.0


def test_sums_of_durations_meet() -> None:
    clock = VirtualClock()
    seen: list[str] = []
    clock.call_at(0.1 + 0.2, lambda: seen.append('0.1 + 0.2'))
    clock.call_at(0.3, lambda: seen.append('0.3'))
    assert clock.advance()
    assert seen == ['0.1 + 0.2', '0.3']
    assert clock.now() == 0.3


def test_time_is_exact_after_many_steps() -> None:
    clock = VirtualClock()
    for _ in range(100_000):
        clock.call_at(clock.now() + 0.1, lambda: None)
        clock.advance()
    assert clock.now() == 10_000.0


def test_advance_runs_calls_newly_armed_for_same_instant() -> None:
    clock = VirtualClock()
    seen: list[float] = []

    def again() -> None:
        clock.call_at(clock.now(), lambda: seen.append(clock.now()))

    clock.call_at(2.0, again)
    clock.call_at(3.0, lambda: None)
    assert clock.advance()
    assert seen == [2.0]
    assert clock.next_deadline() == 3.0


def test_the_past_means_now() -> None:
    clock = VirtualClock()
    seen: list[float] = []

    def look_back() -> None:
        clock.call_at(1.0, lambda: seen.append(clock.now()))

    clock.call_at(5.0, look_back)
    clock.advance()
    assert seen == [5.0]


def test_cancelled_timers_move_no_time() -> None:
    clock = VirtualClock()
    clock.call_at(1.0, lambda: None).cancel()
    timer = clock.call_at(2.0, lambda: None)
    clock.call_at(3.0, lambda: None)
    timer.cancel()
    assert clock.advance()
    assert clock.now() == 3.0
    assert not clock.advance()
