"""Jobs that wait for their start while clocks are set and nodes restart (semantics 6.7, 2.4)."""

from __future__ import annotations

from typing import Any

import pytest
from fakes.action_types import FakeActionTypes
from fakes.clocks import SetClock
from fakes.line import THREE, Line
from fakes.virtual_run import BY, VirtualRun

from bt_orchestrator.engine.runtime.ledger import CLOCK_STEP_S
from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.model import events as e
from bt_orchestrator.model.jobs.job_commands import AddJobs
from bt_orchestrator.model.jobs.order import Job, Terms
from bt_orchestrator.model.keeping.snapshot import state_to_plain
from bt_orchestrator.sim.gateway import VirtualGateway
from bt_orchestrator.sim.run_on import expected_ends
from bt_orchestrator.store.memory import MemoryStore

LINE = Line()
TYPES = FakeActionTypes()
START = 600.0
HEARTBEAT_S = 0.1


class WaitingLine:
    """A line on which nothing is to be done before START, by a clock that somebody sets."""

    def __init__(self) -> None:
        self.clock = SetClock()
        self.store = MemoryStore()
        self._gateway = VirtualGateway(LINE.cell, TYPES, self.clock)
        self._orchestrator = self._start()
        job = Job('W', LINE.script(THREE), 1, terms=Terms(start=START))
        assert self._orchestrator.ask(AddJobs((job,), BY)).accepted

    def go(self, until: float) -> WaitingLine:
        """Let time pass, with a settle whenever a timer asks for one."""
        while (due := self.clock.next_deadline()) is not None and due <= until:
            self.clock.advance()
            self._orchestrator.settle()
        self.clock.sleep(until - self.clock.steady())
        return self

    def set_clock(self, ahead_s: float) -> WaitingLine:
        """Set the clock; the heartbeat causes a settle soon."""
        self.clock.ahead_s = ahead_s
        return self.go(self.clock.steady() + HEARTBEAT_S).settle()

    def settle(self) -> WaitingLine:
        self._orchestrator.settle()
        return self

    def restart(self) -> WaitingLine:
        self._orchestrator.close()
        self._orchestrator = self._start()
        return self.settle()

    @property
    def timers(self) -> int:
        return len(self.clock._deadlines)

    def began(self) -> list[float]:
        """Return by the steady clock when it might start."""
        events = [event for event in self.store.read() if isinstance(event, e.JobMayStart)]
        return [event.time - self.clock.ahead_s for event in events]

    def _start(self) -> Orchestrator:
        return Orchestrator(LINE.cell, self._gateway, self.clock, self.store, auto_resume=True)


def test_6_7_job_starts_on_time_without_other_events() -> None:
    line = WaitingLine().go(START - 1.0)
    assert line.began() == []
    assert line.go(START + 1.0).began() == [START]


@pytest.mark.parametrize('ahead_s', [200.0, -200.0])
def test_6_7_the_clock_that_was_set_decides(ahead_s: float) -> None:
    line = WaitingLine().go(100.0).set_clock(ahead_s)
    line.go(START - ahead_s - 1.0)
    assert line.began() == []
    assert line.go(START - ahead_s + 1.0).began() == [pytest.approx(START - ahead_s)]


def test_6_7_clock_set_past_start_starts_job_at_once() -> None:
    line = WaitingLine().go(100.0).set_clock(1000.0)
    assert line.began() == [pytest.approx(100.0 + HEARTBEAT_S)]


def test_6_7_clock_set_back_keeps_permitted_start() -> None:
    line = WaitingLine().go(START + 0.5).set_clock(-300.0)
    line.restart().go(START + 100.0)
    assert len(line.began()) == 1
    assert any(isinstance(event, e.JobCompleted) for event in line.store.read())


@pytest.mark.parametrize('boot', ['first machine', 'another one', None])
def test_6_7_a_restart_changes_nothing(boot: str | None) -> None:
    line = WaitingLine().go(100.0)
    line.clock.boot = boot
    assert line.restart().go(START - 1.0).began() == []
    assert line.go(START + 1.0).began() == [START]


def test_6_7_start_passed_during_downtime_has_come() -> None:
    line = WaitingLine().go(100.0)
    line.clock.sleep(1000.0)
    assert line.restart().began() == [1100.0]


def test_6_7_creeping_clock_sets_no_extra_timers() -> None:
    line = WaitingLine().go(10.0)
    before = line.timers
    for _ in range(50):
        line.clock.ahead_s += CLOCK_STEP_S / 100
        line.settle()
    assert line.timers == before


def test_6_7_a_forecast_waits_too() -> None:
    run = VirtualRun(LINE.cell, TYPES)
    run.submit('J', LINE.script(THREE), 3)
    job = Job('W', LINE.script(THREE), 1, terms=Terms(start=START))
    assert run.ask(AddJobs((job,), BY)).accepted
    run.go(until=2.0)
    plain: dict[str, Any] = state_to_plain(run.state)
    ends = expected_ends(LINE.cell, TYPES, plain, {}, run.now)
    assert ends['J'] < START < ends['W'] < START + 60.0
    run.go()
    assert ends['W'] == pytest.approx(run.times('job.completed', job='W')[0])
