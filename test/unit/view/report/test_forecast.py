"""What the events of a run say about the line."""

from __future__ import annotations

from dataclasses import replace

import pytest
from fakes.action_types import FakeActionTypes
from fakes.line import THREE, Line
from fakes.script_texts import CELL
from hypothesis import given, settings
from hypothesis import strategies as st

from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.script.cell_file import parse_cell
from bt_orchestrator.sim.simulation import Simulation
from bt_orchestrator.store.memory import MemoryStore
from bt_orchestrator.view.report.forecast import Forecast, JobForecast, WaitLoad, steady_interval_s
from bt_orchestrator.view.report.forecast_fold import ForecastFold, forecast
from bt_orchestrator.view.report.forecast_text import detail_lines


@pytest.fixture
def cell() -> Cell:
    return parse_cell(CELL, 'cell.yaml', FakeActionTypes())


def queued(job: str, time: float = 0.0) -> e.Event:
    return e.JobQueued(job=job, script='s', digest='d', quantity=2, time=time)


def ran(
    task: str, component: str, start: float, end: float, item: str = 'A/1', section: int = 2
) -> list[e.Event]:
    """Return the events of a task."""
    return [
        e.TaskStarted(
            job='A',
            section=section,
            item=item,
            task=task,
            name=task,
            action='/x',
            component=component,
            attempt=1,
            goal=task,
            time=start,
        ),
        e.TaskSucceeded(
            job='A', section=section, item=item, task=task, attempt=1, goal=task, time=end
        ),
    ]


def in_order(*events: e.Event) -> list[e.Event]:
    return sorted(events, key=lambda event: event.time)


def of(cell: Cell, *events: e.Event) -> Forecast:
    return forecast(in_order(*events), cell)


def test_nothing_says_nothing(cell: Cell) -> None:
    empty = of(cell)

    assert (empty.total_s, empty.per_item_s, empty.jobs, empty.bottleneck) == (0.0, None, (), None)
    assert {load.utilisation for load in empty.components} == {0.0}


def test_changed_order_is_reported_in_new_form(cell: Cell) -> None:
    changed = e.JobUpdated(job='A', script='t', digest='d', quantity=5, time=1.0)
    (job,) = of(cell, queued('A'), changed).jobs
    assert (job.script, job.quantity) == ('t', 5)


def test_job_removed_from_queue_has_not_finished(cell: Cell) -> None:
    (job,) = of(cell, queued('A'), e.JobRemoved(job='A', time=1.0)).jobs
    assert (job.finished_s, job.aborted) == (None, False)


def test_items_are_counted_by_how_they_leave(cell: Cell) -> None:
    job = of(
        cell,
        queued('A'),
        e.ItemRemoved(job='A', item='A/1', how='packed', time=1.0),
        e.ItemRemoved(job='A', item='A/2', how='rejected', time=2.0),
        e.ItemRemoved(job='A', item='A/3', how='by_hand', time=3.0),
        e.ItemMissing(job='A', item='A/4', section=1, time=4.0),
        e.JobAborted(job='A', exit_status='aborted', time=5.0),
    ).jobs[0]

    assert (job.packed, job.rejected, job.missing) == (1, 1, 2)
    assert (job.aborted, job.finished_s) == (True, 5.0)


def test_two_continued_tasks_make_one_nonconforming_item(cell: Cell) -> None:
    def continued(task: str, policy: str) -> e.Event:
        return e.TaskContinued(job='A', section=2, item='A/1', task=task, policy=policy)

    some = [continued('x', 'continue'), continued('y', 'continue'), continued('z', 'reject')]
    out = e.ItemRemoved(job='A', section=2, item='A/1', how='packed')

    assert of(cell, queued('A'), *some).jobs[0].nonconforming == 0
    assert of(cell, queued('A'), *some, out).jobs[0].nonconforming == 1
    assert of(cell, queued('A'), continued('z', 'reject'), out).jobs[0].nonconforming == 0


def test_parallel_tasks_make_section_busy_once(cell: Cell) -> None:
    begin = e.CycleStarted(job='A', section=2, item='A/1', beat=1, time=10.0)
    tasks = [*ran('x', 'camera', 10.0, 14.0), *ran('y', 'table', 12.0, 20.0)]
    result = of(cell, queued('A', 10.0), begin, *tasks)

    assert [(load.section, load.cycles, load.busy_s) for load in result.sections] == [(2, 1, 10.0)]
    busy = {load.component: (load.tasks, load.busy_s) for load in result.components}
    assert (busy['camera'], busy['table'], busy['press']) == ((1, 4.0), (1, 8.0), (0, 0.0))
    assert {load.component: load.utilisation for load in result.components}['camera'] == 0.4


def test_running_task_counts_until_last_event(cell: Cell) -> None:
    started, _ = ran('x', 'camera', 2.0, 99.0)
    result = of(cell, queued('A'), started, e.BeatStarted(beat=2, time=5.0))

    assert {load.component: load.busy_s for load in result.components}['camera'] == 3.0


def test_times_count_from_the_first_event(cell: Cell) -> None:
    result = of(
        cell, queued('A', 1e9), e.JobCompleted(job='A', exit_status='completed', time=1e9 + 7.0)
    )

    assert (result.total_s, result.jobs[0].finished_s) == (7.0, 7.0)


def test_bottleneck_has_most_work_per_item(cell: Cell) -> None:
    cycles = [
        e.CycleStarted(job='A', section=2, item='A/1', beat=1),
        e.CycleStarted(job='A', section=2, item='A/2', beat=2),
        e.CycleStarted(job='A', section=3, item='A/1', beat=2),
    ]
    tasks = [*ran('x', 'camera', 0.0, 5.0), *ran('y', 'camera', 5.0, 9.0, 'A/2')]
    tasks += ran('z', 'press', 1.0, 6.0, section=3)
    slowest = of(cell, queued('A'), *cycles, *tasks).bottleneck

    assert slowest is not None
    assert (slowest.section, slowest.pace_s) == (3, 5.0)
    assert (slowest.next_section, slowest.margin_s) == (2, 0.5)


@pytest.mark.parametrize(
    ('times', 'interval'),
    [
        ([], None),
        ([1.0], None),
        ([1.0, 4.0], 3.0),
        ([0.0, 90.0, 95.0, 100.0, 105.0, 195.0], 5.0),
        ([0.0, 50.0, 100.0, 105.0, 110.0, 115.0, 120.0, 140.0, 160.0], 5.0),
    ],
)
def test_filling_and_draining_are_not_the_steady_state(
    times: list[float], interval: float | None
) -> None:
    assert steady_interval_s(times) == interval


# --- several products ---------------------------------------------------------------------------

SLOW = THREE.replace('{id: work, @a2}', '{id: work, @b2}')


def mixed(*orders: tuple[str, int], **seconds: float) -> Forecast:
    """Run jobs one behind the other, each of a script and a quantity."""
    line, fold = Line(seconds=seconds), ForecastFold()
    sim = Simulation(line.cell, line.types, MemoryStore(), [fold])
    for number, (text, quantity) in enumerate(orders, 1):
        script = line.script(text, 'slow' if text is SLOW else 'fast')
        sim.submit([Job(f'J{number}', script, quantity)])
    sim.run()
    sim.close()
    return fold.forecast(line.cell)


AHEAD = THREE.replace('[{id: place', '[{id: get, @a1, requires_conveyor: false}, {id: place')
"""Its source has something to do ahead of each beat but the first."""


def test_first_source_cycle_is_not_steady_state() -> None:
    few, many = (mixed((AHEAD, items)).sections[0].pace_s for items in (2, 40))
    assert few == pytest.approx(many)


def test_a_mix_is_not_faster_than_its_bottleneck() -> None:
    result = mixed((THREE, 9), (SLOW, 6), (THREE, 9), b2=11.0)
    fast, slow, again = result.jobs

    assert (fast.per_item_s, slow.per_item_s, again.per_item_s) == (3.0, 13.0, 3.0)
    assert [job.bottleneck.pace_s for job in result.jobs if job.bottleneck] == [3.0, 13.0, 3.0]
    assert slow.bottleneck is not None
    assert (slow.bottleneck.section, slow.bottleneck.margin_s) == (2, 10.0)
    assert result.per_item_s == pytest.approx((18 * 3.0 + 6 * 13.0) / 24)


def test_draining_line_is_not_faster_than_bottleneck() -> None:
    result = mixed((THREE, 2), a1=11.0)

    assert (result.per_item_s, [job.per_item_s for job in result.jobs]) == (13.0, [13.0])


@given(
    st.lists(st.tuples(st.sampled_from([THREE, SLOW]), st.integers(1, 9)), min_size=1, max_size=4),
    st.fixed_dictionaries({name: st.integers(1, 9) for name in ('a1', 'a2', 'b2', 'a3')}),
)
@settings(max_examples=40)
def test_no_drawn_mix_is_faster_than_its_bottleneck(
    orders: list[tuple[str, int]], seconds: dict[str, int]
) -> None:
    result = mixed(*orders, **{name: float(s) for name, s in seconds.items()})
    results: list[Forecast | JobForecast] = [result, *result.jobs]
    for whole in results:
        if whole.per_item_s is not None:
            assert whole.bottleneck is not None
            assert whole.per_item_s >= whole.bottleneck.pace_s - 1e-9


@pytest.mark.parametrize(
    ('rest', 'message'),
    [
        ((), '      5.0%  waits for flag 4'),
        ((0.04,), '      4.0%  1 other wait'),
        ((0.04, 0.03), '      7.0%  2 other waits, at most 4.0% each'),
    ],
)
def test_waits_that_are_not_shown_are_counted(rest: tuple[float, ...], message: str) -> None:
    result = mixed((THREE, 1))
    shares = (0.2, 0.1, 0.1, 0.1, 0.05, *rest)
    waits = tuple(WaitLoad('flag', f'flag {n}', 1.0, share) for n, share in enumerate(shares))
    first = replace(result.sections[0], waits=waits)
    assert list(detail_lines(replace(result, sections=(first,), components=())))[-1] == message
