"""When the jobs of a running cell will end, from the state of now."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager

import pytest
from fakes.action_types import FakeActionTypes
from fakes.commands import Pause
from fakes.drawn.lines import lines
from fakes.drawn.plan import Plan, Traits
from fakes.line import THREE, Line, with_section
from fakes.operator import ann
from fakes.plan_runs import product_cell, product_scripts
from fakes.profiles import examples
from fakes.virtual_run import defaults
from hypothesis import given
from hypothesis import strategies as st

from bt_orchestrator.engine.runtime.observed_durations import ObservedDurations
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.goal import GoalRequest
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.keeping.snapshot import state_to_plain
from bt_orchestrator.sim import run_on
from bt_orchestrator.sim.run_on import expected_ends
from bt_orchestrator.sim.simulation import Simulation
from bt_orchestrator.store.memory import MemoryStore

TYPES = FakeActionTypes()
LINE = Line(3, seconds={'a2': 5.0})
FLAGGED = THREE + 'lateral_dependencies: [{flag: clear, upstream: work, downstream: pack}]\n'


@contextmanager
def running(
    *quantities: int,
    until_s: float,
    cell: Cell = LINE.cell,
    slower: float = 1.0,
    text: str = FLAGGED,
) -> Iterator[tuple[Simulation, ObservedDurations]]:
    """Yield a line in the middle of its work.

    :param slower: how much longer tasks really take than nominal
    """
    durations = ObservedDurations()

    def really_s(request: GoalRequest) -> float:
        return slower * cell.components[request.component].duration_s(request.task)

    simulation = Simulation(cell, TYPES, MemoryStore(), [durations], duration=really_s)
    script = LINE.script(text)
    simulation.submit(Job(f'J{n}', script, quantity) for n, quantity in enumerate(quantities))
    run_until(simulation, until_s)
    yield simulation, durations
    simulation.close()


def run_until(simulation: Simulation, until_s: float) -> None:
    while (due := simulation.clock.next_deadline()) is not None and due <= until_s:
        simulation.clock.advance()
        simulation.orchestrator.settle()


def expected(
    simulation: Simulation, observed_s: Mapping[str, Mapping[str, float]] | None = None
) -> dict[str, float]:
    plain = json.loads(json.dumps(state_to_plain(simulation.state)))
    now_s = simulation.clock.now()
    return expected_ends(simulation.state.cell, TYPES, plain, observed_s or {}, now_s)


def real_ends(simulation: Simulation) -> dict[str, float | None]:
    simulation.run()
    return {name: job.ended_at for name, job in simulation.state.ended.items()}


@pytest.mark.parametrize('until_s', [0.0, 1.0, 7.9, 13.0, 20.5, 31.0])
def test_forecast_matches_outcome_from_any_moment(until_s: float) -> None:
    with running(3, 2, until_s=until_s) as (simulation, _):
        live, forecast = list(simulation.state.jobs), expected(simulation)
        ends = real_ends(simulation)

        assert live
        assert forecast == pytest.approx({name: ends[name] for name in live})


def test_long_jobs_are_shortened_and_come_out_right(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run_on, 'CYCLES_RUN', 12)
    with running(60, 30, until_s=40.0) as (simulation, _):
        forecast = expected(simulation)

        assert forecast == pytest.approx(real_ends(simulation), rel=0.01)


def steps_ahead(simulation: Simulation) -> tuple[int, dict[str, float]]:
    """Return what a forecast costs, and what it says."""
    plain = json.loads(json.dumps(state_to_plain(simulation.state)))
    run = run_on.RunOn(simulation.state.cell, TYPES, plain, {}, simulation.clock.now())
    with closing(run):
        run.go_on(math.inf)
        return run.steps, run.ends_s()


@pytest.mark.parametrize('seconds', [{}, {'a2': 5.0}])
def test_line_runs_on_until_it_repeats_itself(seconds: dict[str, float]) -> None:
    cell = Line(3, seconds=seconds).cell
    with running(40, until_s=30.0, cell=cell) as (simulation, _):
        few, forecast = steps_ahead(simulation)
        assert forecast == pytest.approx(real_ends(simulation))
    with running(400, until_s=30.0, cell=cell) as (simulation, _):
        many, forecast = steps_ahead(simulation)
        assert forecast == pytest.approx(real_ends(simulation))

    assert many == few < 60


def test_slowly_settling_line_does_not_repeat_itself_early() -> None:
    text = with_section(
        2,
        """
          release_conveyor: after_last_conveyor_task
          tasks: [{id: work, @a2}, {id: clean, @b2, requires_conveyor: false}]
        """,
    )  # 8.0 s per item, until cleaning has come to be half a second later with each of them
    cell = Line(3, seconds={'a1': 6.0, 'b2': 7.5}).cell
    with running(40, until_s=30.0, cell=cell, text=text) as (simulation, _):
        forecast = expected(simulation)

        assert forecast == pytest.approx(real_ends(simulation))


def test_items_with_differing_ways_are_all_run() -> None:
    text = with_section(
        2, '[{id: work, @a2, when: {value: "${item.number}", at_least: 20}}, {id: look, @b2}]'
    )
    with running(40, until_s=9.0, text=text) as (simulation, _):
        forecast = expected(simulation)

        assert forecast == pytest.approx(real_ends(simulation))


def test_ends_are_known_up_to_returned_moment(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with running(100, 60, until_s=30.0) as (simulation, _):
        plain = json.loads(json.dumps(state_to_plain(simulation.state)))
        run = run_on.RunOn(simulation.state.cell, TYPES, plain, {}, simulation.clock.now())
        monkeypatch.setattr('time.monotonic', lambda: float('J0' in run.ends_s()))
        with closing(run):
            known_s = run.go_on(1.0)
            assert run.ends_s().keys() == run.ends_s(known_s).keys() == {'J0'}
            assert known_s == pytest.approx(run.ends_s()['J0'])


@examples(10, 500)
@given(
    lines(Traits(faults=False, rejects=True, most_sections=5)), st.sampled_from([0.0, 7.3, 40.0])
)
def test_drawn_lines_do_what_is_forecast(plan: Plan, until_s: float) -> None:
    cell = product_cell(plan)
    for script in product_scripts(plan, cell).values():
        jobs = [Job(name, script, 40, defaults(script)) for name in 'JK']
        with closing(Simulation(cell, TYPES, MemoryStore())) as simulation:
            simulation.submit(jobs)
            run_until(simulation, until_s)
            forecast = expected(simulation)
            ends = real_ends(simulation)
            assert forecast == pytest.approx({name: ends[name] for name in forecast})


def test_observed_durations_outweigh_written_ones() -> None:
    with running(12, until_s=80.0, slower=2.0) as (simulation, durations):
        nominal, seen = expected(simulation), expected(simulation, durations.seconds())
        (end_s,) = real_ends(simulation).values()

        assert seen['J0'] == pytest.approx(end_s)
        assert nominal['J0'] < seen['J0'] - 40.0


def test_five_quick_goals_per_task_suffice_for_forecast() -> None:
    with running(30, until_s=20.0, slower=0.25) as (simulation, durations):
        took_s = durations.seconds()
        assert took_s['a3'] == {'TASK_A': 0.25}
        forecast = expected(simulation, took_s)
        left_s = forecast['J0'] - simulation.clock.now()
        (end_s,) = real_ends(simulation).values()
        assert end_s is not None

        assert left_s == pytest.approx(end_s - 20.0, rel=0.05)


def test_unseen_tasks_are_assumed_equally_slow() -> None:
    with running(12, until_s=4.0, slower=2.0) as (simulation, durations):
        assert 'a3' not in durations.seconds()
        forecast = expected(simulation, durations.seconds())
        (end_s,) = real_ends(simulation).values()

        assert forecast['J0'] == pytest.approx(end_s)


def test_faults_of_simulated_controllers_are_not_foreseen() -> None:
    cell = Line(3, seconds={'a2': 5.0}, faults={'a2': '#3=abort'}).cell
    with running(4, until_s=3.0, cell=cell) as (simulation, _):
        assert expected(simulation)
        assert real_ends(simulation) == {}


def test_a_cell_that_somebody_stopped_has_no_forecast() -> None:
    with running(4, until_s=3.0) as (simulation, _):
        simulation.orchestrator.ask(Pause(ann('lunch')))

        assert expected(simulation) == {}


def test_overlong_run_leaves_jobs_unknown(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run_on, 'LONGEST_S', 0.0)
    with running(4, until_s=3.0) as (simulation, _):
        assert expected(simulation) == {}
