"""How long tasks take here, from the events of a run."""

from __future__ import annotations

import pytest
from fakes.line import THREE, Line

from bt_orchestrator.engine.runtime.observed_durations import ObservedDurations, as_observed
from bt_orchestrator.model import events as e
from bt_orchestrator.model.events import TaskKey
from bt_orchestrator.model.goal import GoalRequest
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.sim.simulation import Simulation
from bt_orchestrator.store.memory import MemoryStore
from bt_orchestrator.view.report.pace import expected_ends_s

LINE = Line(seconds={'a2': 5.0})
KEY = TaskKey('J', 2, 'J/1', 'work')


def started(time: float) -> e.TaskStarted:
    return e.TaskStarted(
        **KEY._asdict(),
        name='TASK_A',
        action='/a2/do',
        component='a2',
        attempt=1,
        goal='g',
        time=time,
    )


def succeeded(time: float) -> e.TaskSucceeded:
    return e.TaskSucceeded(**KEY._asdict(), attempt=1, goal='g', time=time)


def test_it_is_the_usual_one_of_the_last() -> None:
    durations = ObservedDurations()
    for took_s in (90.0, 90.0, *[4.0] * 5, 60.0, 2.0, 4.0, 4.0):
        durations.publish([started(100.0), succeeded(100.0 + took_s)])
    assert (durations.seconds(), durations.kinds) == ({'a2': {'TASK_A': 4.0}}, 1)


def test_a_clock_that_was_set_back_says_nothing() -> None:
    durations = ObservedDurations()
    durations.publish([started(3600.0), succeeded(4.0)])
    assert durations.seconds() == {}


def test_a_clock_that_was_set_forward_says_nothing() -> None:
    durations = ObservedDurations()
    durations.publish([started(4.0), e.ClockStepped(seconds=3600.0), succeeded(3608.0)])
    assert durations.seconds() == {}


def test_what_ran_while_no_orchestrator_did_says_nothing() -> None:
    durations = ObservedDurations()
    restart = e.OrchestratorStarted(cell='c', digest='d', time=900.0)
    durations.publish([started(1.0), restart, succeeded(901.0)])
    assert durations.seconds() == {}


def test_predicted_ends_use_observed_durations() -> None:
    durations = ObservedDurations()

    def quarter_s(request: GoalRequest) -> float:
        return LINE.cell.components[request.component].duration_s(request.task) / 4

    sim = Simulation(LINE.cell, LINE.types, MemoryStore(), [durations], duration=quarter_s)
    sim.submit([Job('J', LINE.script(THREE), 40), Job('K', LINE.script(THREE), 40)])
    while sim.clock.now() < 4.0:
        sim.clock.advance()
        sim.orchestrator.settle()
    now_s = sim.clock.now()
    seen = expected_ends_s(sim.state, as_observed(LINE.cell, durations.seconds()))
    nominal = expected_ends_s(sim.state, LINE.cell)
    sim.run()
    real = {name: (job.ended_at or 0.0) - now_s for name, job in sim.state.ended.items()}
    sim.close()

    assert seen == {name: pytest.approx(end_s, rel=0.05) for name, end_s in real.items()}
    assert nominal == {name: pytest.approx(4 * seconds) for name, seconds in seen.items()}


def test_removed_component_is_ignored() -> None:
    seen = as_observed(LINE.cell, {'gone': {'TASK_A': 9.0}, 'a1': {'TASK_A': 3.0}})
    assert seen.components['a1'].duration_s('TASK_A') == 3.0
    assert seen.components.keys() == LINE.cell.components.keys()
