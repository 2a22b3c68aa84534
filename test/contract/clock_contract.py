"""What every Clock does, whoever makes time pass (see ports/clock.py).

Subclass it and say how a bench is made.
"""

from __future__ import annotations

import random
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from typing import Any, Protocol

import pytest
from ros_domain import kept_domain

from bt_orchestrator.ports import Clock, Timer

EXACT_S = 1e-6
"""A float of seconds since a boot is not finer."""


class ClockBench(Protocol):
    """A clock, and time that passes when it is let."""

    @property
    def clock(self) -> Clock:
        """What is tested."""

    def run_until(self, condition: Callable[[], Any]) -> None:
        """Let time pass until a condition holds; fails if it does not in time."""

    def run_for(self, seconds: float) -> None:
        """Let so much time of the clock pass, or more."""

    def close(self) -> None:
        """Put everything away."""


class ClockContract(ABC):
    """The contract; one bench serves all tests."""

    @staticmethod
    @abstractmethod
    def make_bench() -> ClockBench:
        """Return a running bench."""

    @pytest.fixture(scope='class')
    @classmethod
    def bench(cls) -> Iterator[ClockBench]:
        with kept_domain():
            bench = cls.make_bench()
            yield bench
            bench.close()

    def test_both_times_go_on(self, bench: ClockBench) -> None:
        steady, now = bench.clock.steady(), bench.clock.now()
        bench.run_for(0.2)
        assert bench.clock.steady() >= steady + 0.2 - EXACT_S
        assert bench.clock.now() > now

    def test_calls_once_and_not_too_early(self, bench: ClockBench) -> None:
        calls = _Calls(bench)
        due = bench.clock.steady() + 0.2
        calls.at(due, 'it')
        bench.run_until(lambda: calls.names)
        assert calls.times[0] >= due - EXACT_S
        bench.run_for(0.1)
        assert calls.names == ['it']

    def test_calls_follow_time_then_arming_order(self, bench: ClockBench) -> None:
        calls = _Calls(bench)
        start = bench.clock.steady()
        drawn = random.Random(1)
        steps = [drawn.randrange(20) for _ in range(60)]
        for number, step in enumerate(steps):
            calls.at(start + 0.1 + step / 100, f'{step} {number}')
        bench.run_until(lambda: len(calls.names) == len(steps))
        expected = sorted(range(60), key=lambda number: (steps[number], number))
        assert calls.names == [f'{steps[number]} {number}' for number in expected]

    def test_an_earlier_one_overtakes(self, bench: ClockBench) -> None:
        calls = _Calls(bench)
        late = calls.at(bench.clock.steady() + 3600.0, 'late')
        calls.at(bench.clock.steady() + 0.05, 'early')
        bench.run_until(lambda: calls.names)
        assert calls.names == ['early']
        late.cancel()

    def test_past_deadline_fires_soon_but_never_synchronously(self, bench: ClockBench) -> None:
        calls = _Calls(bench)
        bench.run_for(0.1)
        began = bench.clock.steady()
        for past_s in (0.05, 0.0):
            calls.at(began - past_s, f'{past_s}')
        assert calls.names == []
        bench.run_until(lambda: len(calls.names) == 2)
        assert min(calls.times) >= began

    def test_cancelled_is_not_called(self, bench: ClockBench) -> None:
        calls = _Calls(bench)
        due = bench.clock.steady() + 0.05
        cancelled = calls.at(due, 'cancelled')
        calls.at(due + 0.05, 'kept')
        cancelled.cancel()
        cancelled.cancel()
        bench.run_until(lambda: calls.names)
        assert calls.names == ['kept']

    def test_may_be_cancelled_when_it_has_passed(self, bench: ClockBench) -> None:
        calls = _Calls(bench)
        timer = calls.at(bench.clock.steady() + 0.02, 'it')
        bench.run_until(lambda: calls.names)
        timer.cancel()
        calls.at(bench.clock.steady() + 0.02, 'next')
        bench.run_until(lambda: calls.names == ['it', 'next'])

    def test_cancelled_by_one_of_the_same_instant(self, bench: ClockBench) -> None:
        calls = _Calls(bench)
        due = bench.clock.steady() + 0.05
        timers: list[Timer] = []

        def cancel_next() -> None:
            timers[0].cancel()

        bench.clock.call_at(due, cancel_next)
        timers.append(calls.at(due, 'cancelled'))
        calls.at(due, 'kept')
        bench.run_until(lambda: calls.names)
        assert calls.names == ['kept']

    def test_arms_again_inside_of_a_callback(self, bench: ClockBench) -> None:
        calls = _Calls(bench)

        def again() -> None:
            calls.note('tick')
            if len(calls.names) < 4:  # later, and now
                after_s = 0.02 * (len(calls.names) % 2)
                bench.clock.call_at(bench.clock.steady() + after_s, again)

        bench.clock.call_at(bench.clock.steady() + 0.02, again)
        bench.run_until(lambda: calls.names == ['tick'] * 4)

    def test_uptime_goes_on_with_the_steady_time(self, bench: ClockBench) -> None:
        before, steady = bench.clock.uptime(), bench.clock.steady()
        if before is None:  # it does not tell: then never
            bench.run_for(0.1)
            assert bench.clock.uptime() is None
            return
        bench.run_for(0.1)
        after = bench.clock.uptime()
        assert after is not None
        assert after.boot == before.boot != ''
        passed_s = bench.clock.steady() - steady
        assert after.seconds - before.seconds == pytest.approx(passed_s, abs=1.0)


class _Calls:
    """Who was called, in order, and when."""

    def __init__(self, bench: ClockBench) -> None:
        self._clock = bench.clock
        self.names: list[str] = []
        self.times: list[float] = []

    def at(self, time: float, name: str) -> Timer:
        return self._clock.call_at(time, lambda: self.note(name))

    def note(self, name: str) -> None:
        self.names.append(name)
        self.times.append(self._clock.steady())
