"""Somebody sets the wall clock: what waits goes on as if nothing were (semantics 2.4, 2.6)."""

from __future__ import annotations

import pytest
from fakes.action_types import FakeActionTypes
from fakes.clocks import SetClock
from fakes.commands import Pause, SetService, Stop
from fakes.line import Line, with_section
from fakes.operator import ann

from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.engine.runtime.overview import Overview
from bt_orchestrator.model import events as e
from bt_orchestrator.model.commands import Command
from bt_orchestrator.model.jobs.job_commands import AddJobs
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.status import CellStatus
from bt_orchestrator.sim.gateway import VirtualGateway
from bt_orchestrator.store.memory import MemoryStore

HOUR_S = 3600.0
WORK_AT = 3.0
"""When section 2 of the shortest line begins with its first item."""

either_way = pytest.mark.parametrize('step_s', [HOUR_S, -HOUR_S])


class SetLine:
    """The shortest line, on a machine whose clock is set while the second section works."""

    def __init__(self, fault: str, options: str = '', *, at: str = 'a2') -> None:
        line = Line(faults={at: fault}, topics=('a1',))
        self._cell = line.cell
        self.clock = SetClock()
        self._gateway = VirtualGateway(line.cell, FakeActionTypes(), self.clock)
        self.store = MemoryStore()
        self.orchestrator = self._start()
        more = f', {options}' if options else ''
        script = line.script(with_section(2, f'- {{id: work, @a2{more}}}'))
        assert self.orchestrator.ask(AddJobs((Job('J', script, 1),))).accepted

    def go(self, until: float = 1e6) -> SetLine:
        self.orchestrator.settle()
        while self.orchestrator.state.jobs:
            due = self.clock.next_deadline()
            if due is None or due > until:
                break
            self.clock.advance()
            self.orchestrator.settle()
        return self

    def restart(self) -> None:
        self.orchestrator.close()
        self.orchestrator = self._start()

    def when(self, kind: type[e.TaskEvent]) -> list[float]:
        """Return when something happened to `work`, by the time that nobody set."""
        return [
            event.time - self.clock.ahead_s
            for event in self.store.read()
            if isinstance(event, kind) and event.task == 'work'
        ]

    def steps(self) -> list[e.ClockStepped]:
        """Return what was recorded of the clock."""
        return [event for event in self.store.read() if isinstance(event, e.ClockStepped)]

    @property
    def ended(self) -> bool:
        return not self.orchestrator.state.jobs

    def _start(self) -> Orchestrator:
        return Orchestrator(self._cell, self._gateway, self.clock, self.store, auto_resume=True)


@either_way
def test_2_4_clock_step_does_not_change_goal_timeout(step_s: float) -> None:
    run = SetLine('#1=hang', 'timeout: 10').go(until=WORK_AT + 1)
    run.clock.ahead_s = step_s
    run.go(until=WORK_AT + 9)
    assert run.when(e.TaskCancelRequested) == []
    run.go()
    assert run.when(e.TaskCancelRequested) == [WORK_AT + 10]


@either_way
def test_2_4_clock_step_keeps_cancel_grace(step_s: float) -> None:
    run = SetLine('#1=ignore_cancel', 'timeout: 2').go(until=WORK_AT + 2)
    assert run.when(e.TaskCancelRequested) == [WORK_AT + 2]
    run.clock.ahead_s = step_s
    run.go()
    assert run.when(e.TaskFailed) == [WORK_AT + 7]


@either_way
def test_2_6_a_retry_comes_after_its_delay(step_s: float) -> None:
    run = SetLine('#1=abort', 'retries: 1, retry_delay: 5').go(until=WORK_AT + 2)
    run.clock.ahead_s = step_s
    run.go()
    assert run.ended
    assert run.when(e.TaskStarted)[1] == WORK_AT + 1 + 5


@either_way
def test_2_6_retry_after_restart_keeps_its_delay(step_s: float) -> None:
    run = SetLine('#1=abort', 'retries: 1, retry_delay: 5').go(until=WORK_AT + 2)
    run.clock.ahead_s = step_s
    run.restart()
    run.go()
    assert run.ended
    assert run.when(e.TaskStarted)[1] == WORK_AT + 1 + 5


def test_2_6_retry_after_boot_waits_whole_delay_again() -> None:
    run = SetLine('#1=abort', 'retries: 1, retry_delay: 5').go(until=WORK_AT + 2)
    run.clock.boot = 'first machine, later'
    restarted = run.clock.steady()
    run.restart()
    run.go()
    assert run.when(e.TaskStarted)[1] == restarted + 5


@either_way
def test_2_4_adopted_goal_keeps_remaining_timeout(step_s: float) -> None:
    run = SetLine('#1=hang', 'timeout: 10').go(until=WORK_AT + 4)
    run.clock.ahead_s = step_s
    run.restart()
    run.go()
    assert run.when(e.TaskCancelRequested) == [pytest.approx(WORK_AT + 10)]


@pytest.mark.parametrize('ahead_s', [HOUR_S, 0.0, -HOUR_S])
def test_2_4_goal_of_another_machine_gets_full_timeout(ahead_s: float) -> None:
    run = SetLine('#1=hang', 'timeout: 10').go(until=WORK_AT + 4)
    run.clock.ahead_s, run.clock.boot = ahead_s, 'second machine'
    restarted = run.clock.steady()
    run.restart()
    run.go()
    assert run.when(e.TaskCancelRequested) == [restarted + 10]


@either_way
def test_7_2_a_line_that_starves_is_suspended_in_time(step_s: float) -> None:
    run = SetLine('#0=not_ready:8', at='a1')
    run.clock.ahead_s = step_s
    run.go(until=7.0)
    reasons = [event for event in run.store.read() if isinstance(event, e.StopReasonChanged)]
    assert [(x.stop_reason, x.time - step_s) for x in reasons] == [('starved', 1.0)]


def test_7_2_time_in_state_is_never_negative() -> None:
    run = SetLine('#1=abort', 'on_failure: continue').go(until=WORK_AT)
    run.clock.ahead_s = -HOUR_S
    run.go()
    assert run.ended
    times = run.orchestrator.state.times(run.clock.now())
    assert all(seconds >= 0.0 for seconds in times.values())


@either_way
def test_2_4_setting_the_clock_is_an_event(step_s: float) -> None:
    run = SetLine('#1=hang', 'timeout: 10').go(until=WORK_AT + 1)
    assert run.steps() == []
    run.clock.ahead_s = step_s
    run.orchestrator.settle()
    [step] = run.steps()
    assert step.seconds == pytest.approx(step_s)
    assert step.time == run.clock.now()


@pytest.mark.parametrize('slew_s', [0.4, -0.4])
def test_2_4_a_clock_that_is_slewed_is_no_event(slew_s: float) -> None:
    run = SetLine('#1=late:100', 'timeout: none')
    for second in range(1, 60):
        run.clock.ahead_s = slew_s * second
        run.clock.call_at(float(second), lambda: None)
        run.go(until=float(second))
    assert run.steps() == []


@either_way
def test_7_2_time_in_state_is_elapsed_time(step_s: float) -> None:
    run = SetLine('#1=hang', 'timeout: 10').go(until=WORK_AT)
    since = run.clock.steady() - run.orchestrator.state.packml_since
    run.clock.ahead_s = step_s
    run.orchestrator.settle()
    state = run.orchestrator.state
    assert run.clock.now() - state.packml_since == pytest.approx(since)
    (work,) = state.running.values()
    assert run.clock.now() - work.started == pytest.approx(run.clock.steady() - WORK_AT)
    run.go()
    assert sum(run.orchestrator.state.times(run.clock.now()).values()) == pytest.approx(
        run.clock.steady()
    )


def test_2_4_clock_step_is_recorded_before_later_events() -> None:
    run = SetLine('#1=hang', 'timeout: 10').go(until=WORK_AT)
    run.clock.ahead_s = HOUR_S
    run.orchestrator.ask(Pause(ann('it is so')))
    last = [type(event) for event in run.store.read() if event.time > HOUR_S / 2]
    assert last[:2] == [e.ClockStepped, e.OperatorDecided]


@either_way
def test_2_4_uptime_proves_clock_step_during_downtime(step_s: float) -> None:
    run = SetLine('#1=hang', 'timeout: none').go(until=WORK_AT + 1)
    last = run.orchestrator.state.time
    in_state = dict(run.orchestrator.state.times(last))
    run.clock.sleep(600.0)
    run.clock.ahead_s = step_s
    run.restart()
    run.orchestrator.settle()
    [step] = run.steps()
    assert step.seconds == pytest.approx(step_s)
    assert step.time == pytest.approx(last + step_s)
    started = [x for x in run.store.read() if isinstance(x, e.OrchestratorStarted)][-1]
    assert started.seq == step.seq + 1
    assert started.time == pytest.approx(step.time + 600.0, abs=2.0)
    state = run.orchestrator.state
    assert state.times(started.time) == pytest.approx(in_state)
    (work,) = state.running.values()
    assert run.clock.now() - work.started == pytest.approx(run.clock.steady() - WORK_AT)


@either_way
@pytest.mark.parametrize('boot', ['second machine', None])
def test_2_4_no_step_is_told_without_the_same_boot(step_s: float, boot: str | None) -> None:
    run = SetLine('#1=hang', 'timeout: none').go(until=WORK_AT + 1)
    run.clock.ahead_s, run.clock.boot = step_s, boot
    run.restart()
    run.orchestrator.settle()
    assert run.steps() == []


def test_2_4_unchanged_clock_during_downtime_is_no_event() -> None:
    run = SetLine('#1=hang', 'timeout: none').go(until=WORK_AT + 1)
    run.clock.sleep(86_400.0)
    run.restart()
    run.orchestrator.settle()
    assert run.steps() == []


@either_way
def test_2_4_two_restarts_tell_one_step_once(step_s: float) -> None:
    run = SetLine('#1=hang', 'timeout: none').go(until=WORK_AT + 1)
    run.clock.ahead_s = step_s
    run.restart()
    run.orchestrator.settle()
    run.clock.sleep(60.0)
    run.restart()
    run.orchestrator.settle()
    assert len(run.steps()) == 1


@either_way
def test_2_4_clock_step_during_run_is_reported_once(step_s: float) -> None:
    run = SetLine('#1=hang', 'timeout: none').go(until=WORK_AT + 1)
    run.clock.ahead_s = step_s
    run.orchestrator.settle()
    run.restart()
    run.orchestrator.settle()
    assert len(run.steps()) == 1


# --- ages: what the status tells of what still lasts ------------------------------------------


class Ages:
    """A line whose first task failed, with a component out of service and a stop: all last."""

    def __init__(self) -> None:
        self.run = SetLine('#1=abort').go(until=WORK_AT + 10)
        self.ask(SetService('b1', in_service=False, by=ann('it leaks')))
        self.ask(Stop(ann('enough')))
        self.overview = Overview(self.run.orchestrator)
        self.look()
        self.run.clock.sleep(20.0)

    def ask(self, command: Command) -> None:
        assert self.run.orchestrator.ask(command).accepted

    def look(self) -> CellStatus:
        return self.overview.status(self.run.clock.now())

    def told(self) -> dict[str, float]:
        status = self.look()
        (hold,) = status.holds
        assert status.stands is not None
        assert status.wish is not None
        out = {entry.name: entry.out_of_service_since for entry in status.components}['b1']
        assert out is not None
        begun = {
            'state': status.state_since,
            'hold': hold.since,
            'stands': status.stands.since,
            'out of service': out,
            'stop': status.wish.time,
        }
        return {what: status.stamp - since for what, since in begun.items()}


@either_way
def test_2_4_status_ages_ignore_clock_step(step_s: float) -> None:
    ages = Ages()
    before = ages.told()
    assert all(age >= 20.0 for age in before.values())
    ages.run.clock.ahead_s = step_s
    ages.run.orchestrator.settle()
    assert ages.told() == pytest.approx(before)
    ages.run.clock.sleep(5.0)
    assert ages.told() == pytest.approx({what: age + 5.0 for what, age in before.items()})


@either_way
def test_2_4_ages_stay_right_over_a_restart(step_s: float) -> None:
    ages = Ages()
    before = ages.told()
    ages.run.clock.ahead_s = step_s
    ages.run.restart()
    ages.run.orchestrator.settle()
    ages.overview = Overview(ages.run.orchestrator)
    ages.look()
    ages.run.clock.sleep(5.0)
    after = ages.told()
    for what in ('hold', 'out of service', 'stop'):
        assert after[what] == pytest.approx(before[what] + 5.0, abs=0.01)


@either_way
def test_7_4_standstill_stays_reported_before_step_is_recorded(step_s: float) -> None:
    ages = Ages()
    assert ages.look().stands is not None
    ages.run.clock.ahead_s = step_s
    assert ages.look().stands is not None
    ages.run.orchestrator.settle()
    assert ages.told()['stands'] == pytest.approx(20.0)
