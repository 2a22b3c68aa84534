"""A job beside its forecast, on journals of real runs of the engine."""

from __future__ import annotations

import json

import pytest
from fakes.action_types import FakeActionTypes
from fakes.line import THREE, Line, with_section
from fakes.profiles import examples
from fakes.stepped import Steps, drawn_steps, stepped
from fakes.virtual_run import VirtualRun
from hypothesis import example, given
from hypothesis import strategies as st

from bt_orchestrator.base.errors import NotKept
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.goal import GoalRequest
from bt_orchestrator.model.judging import used_ids
from bt_orchestrator.sim.looking_back import LookingBack, NoForecast, Watchers
from bt_orchestrator.store.memory import MemoryRecords, MemoryStore
from bt_orchestrator.view.drawing.gantt import GanttFold
from bt_orchestrator.view.report.account.planned import US
from bt_orchestrator.view.report.reading import Reading
from bt_orchestrator.view.report.retrospect.retrospect import Retrospect
from bt_orchestrator.view.report.retrospect.text import retrospect_plain, retrospect_text

TYPES = FakeActionTypes()
LINE = Line(3, seconds={'a2': 5.0})
RETRIED = with_section(2, '- {id: work, @a2, retries: 1}')


def ran(line: Line, *quantities: int, text: str = THREE, slower: float = 0.0) -> VirtualRun:
    """Run jobs J0, J1 and so on, up to where a person is asked.

    :param slower: seconds that a2 really takes longer
    """

    def really_s(request: GoalRequest) -> float:
        more_s = slower if request.component == 'a2' else 0.0
        return line.cell.components[request.component].duration_s(request.task) + more_s

    run = VirtualRun(line.cell, TYPES, duration=really_s)
    for number, quantity in enumerate(quantities):
        run.submit(f'J{number}', line.script(text), quantity)
    return run.go()


def looked(
    run: VirtualRun, job: str, cell: Cell = LINE.cell, *, usual: bool = False
) -> Retrospect:
    reading = Reading(MemoryRecords(run.store))
    return LookingBack(reading, cell, TYPES, 'the journal').at(job, usual=usual)


def difference_us(retrospect: Retrospect) -> dict[str, int]:
    return {pair.what: pair.more for pair in retrospect.times() if pair.more}


@pytest.mark.parametrize('job', ['J0', 'J1', 'J2'])
def test_run_as_forecast_is_equal_in_every_figure(job: str) -> None:
    recap = looked(ran(LINE, 3, 2, 4), job)
    assert recap.late_us == 0
    assert recap.forecast.works == recap.real.works
    assert recap.real.works
    pairs = [*recap.times(), *recap.items(), *recap.busy(), recap.total]
    assert all(pair.more == 0 for pair in pairs)
    assert sum(pair.real for pair in recap.times()) == recap.total.real
    assert [*recap.tasks()] == []
    assert recap.first_deviation() is recap.worst_deviation() is None


@example(steps=[(0, 1.0)], job='J1')
@examples(10, 300)
@given(drawn_steps(), st.sampled_from(['J0', 'J1', 'J2']))
def test_a_clock_that_is_set_changes_no_difference(steps: Steps, job: str) -> None:
    run = ran(LINE, 3, 2, 4, slower=2.0)
    store = MemoryStore()
    store.append(stepped(run.store.read(), steps))
    reading = Reading(MemoryRecords(store))
    recap = LookingBack(reading, LINE.cell, TYPES, 'the journal').at(job)
    assert figures_of(recap) == figures_of(looked(run, job))
    first, plain = recap.first_deviation(), looked(run, job).first_deviation()
    assert first is not None
    assert plain is not None
    assert first.real.key == plain.real.key
    assert retrospect_plain(recap)['notes']


def figures_of(retrospect: Retrospect) -> list[object]:
    pairs = [*retrospect.times(), *retrospect.items(), *retrospect.busy(), retrospect.total]
    return [retrospect.late_us, *pairs, *retrospect.tasks()]


def test_forecast_does_not_need_previously_used_ids(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(used_ids, 'FULL', 1)
    run = ran(LINE, 3, 2, 4)
    assert len(run.state.order_ids.sealed) == 3
    assert looked(run, 'J2').late_us == 0


def test_a_slow_component_is_named() -> None:
    recap = looked(ran(LINE, 5, slower=2.0), 'J0')
    assert recap.late_us == 10 * US, 'two seconds for each of five items'
    assert difference_us(recap) == {'production': 10 * US}
    assert next(recap.busy()) == ('a2', 25 * US, 35 * US)
    (task,) = recap.tasks()
    assert task == ('a2', 'TASK_A', 5, 25 * US, 35 * US)
    first, worst = recap.first_deviation(), recap.worst_deviation()
    assert first is not None
    assert first.real.key.task.item == 'J0/1'
    assert first.late_us == 2 * US
    assert worst is not None
    assert worst.late_us == 10 * US


def test_what_comes_after_the_end_is_not_counted() -> None:
    recap = looked(ran(LINE, 5, 3, slower=-2.0), 'J0')
    assert difference_us(recap) == {'production': -10 * US}
    busy = {pair.what: (pair.forecast, pair.real) for pair in recap.busy()}
    assert busy['a2'] == (25 * US, 15 * US)
    assert busy['conveyor'] == (12 * US, 12 * US), 'later moves are of the next job alone'


@pytest.mark.parametrize('part_s', [4e-7, 6e-7])
def test_job_end_is_recognized_despite_time_rounding(part_s: float) -> None:
    recap = looked(ran(LINE, 1, slower=part_s), 'J0')
    assert recap.late_us == round(part_s * US)


def test_move_in_progress_at_start_is_counted() -> None:
    run = VirtualRun(LINE.cell, TYPES)
    run.submit('J0', LINE.script(THREE), 1)
    early = '[{id: ready, @b1, requires_conveyor: false}, {id: place, @a1, qty_change: 1}]'
    run.submit('J1', LINE.script(THREE.replace('[{id: place, @a1, qty_change: 1}]', early)), 1)
    run.go()
    recap = looked(run, 'J1')
    (first, *_) = (r['time'] for r in run.all('task.started', task='index'))
    assert first * US == recap.begin_us
    moves = len(run.all('task.started', task='index'))
    assert recap.real.busy_us['conveyor'] == recap.forecast.busy_us['conveyor']
    assert recap.real.busy_us['conveyor'] == moves * 2 * US


def test_retries_and_holds_account_for_the_difference() -> None:
    line = Line(3, seconds={'a2': 5.0}, faults={'a2': '#2=abort #5=abort #6=abort'})
    run = ran(line, 5, text=RETRIED)
    (hold,) = run.state.holds
    run.sim.clock.call_at(run.now + 60.0, lambda: None)
    assert run.sim.clock.advance()
    run.answer('retry', hold)
    run.go()
    recap = looked(run, 'J0', line.cell)
    more = difference_us(recap)
    assert more == {'own_fault': 60 * US, 'rework': 15 * US}
    assert sum(more.values()) == recap.total.more == recap.late_us
    first = recap.first_deviation()
    assert first is not None
    assert (first.real.reason, first.real.key.task.item) == ('aborted', 'J0/2')
    text = '\n'.join(retrospect_text(recap))
    assert 'first deviation, at ' in text
    assert 'section 2, work of J0/2 (TASK_A) at a2 failed: aborted\n' in text
    assert 'retry by Ann' in text
    plain = json.loads(json.dumps(retrospect_plain(recap)))
    assert plain['first_deviation']['reason'] == 'aborted'
    assert plain['late_s'] == recap.total.more / US


def test_a_job_that_runs_is_compared_so_far() -> None:
    run = VirtualRun(LINE.cell, TYPES)
    run.submit('J0', LINE.script(THREE), 6)
    run.go(until=20.0)
    recap = looked(run, 'J0')
    assert recap.late_us is None
    assert recap.real.until_us == 18 * US, 'the last event'
    assert recap.real.busy_us['a2'] == 11 * US, 'two items, and one second of the third'
    assert recap.forecast.end_us is not None
    assert recap.forecast.end_us > recap.real.until_us == recap.forecast.until_us
    pairs = [*recap.times(), *recap.items(), *recap.busy(), recap.total]
    assert all(pair.more == 0 for pair in pairs)
    assert 'the job has not ended: times and items are compared up to' in '\n'.join(
        retrospect_text(recap)
    )


def test_usual_durations_are_those_before_the_job() -> None:
    run = ran(LINE, 9, 3, slower=2.0)
    late_us = looked(run, 'J1').late_us
    assert late_us == 10 * US, 'three items of J1, and two of J0 before them'
    assert looked(run, 'J1', usual=True).late_us == 0


def test_another_cell_file_is_said() -> None:
    other = Line(3, seconds={'a2': 9.0})
    recap = looked(ran(LINE, 2), 'J0', other.cell)
    assert recap.cell_differs
    assert recap.late_us == -8 * US
    assert 'the node ran with another cell file than this one' in '\n'.join(retrospect_text(recap))


def test_forecast_that_needs_a_person_is_refused() -> None:
    unless = "fails_unless: {value: '${results.work.measurement}', at_least: 4.0}"
    line = Line(3, faults={'a2': '#1=reads:5.0'})
    run = ran(line, 1, text=with_section(2, f'- {{id: work, @a2, {unless}}}'))
    assert run.ended, 'the real scale read what is wanted; the simulated one reads 0'
    with pytest.raises(NoForecast, match=r'a person has to answer: section 2, work \(TASK_A\)'):
        looked(run, 'J0', line.cell)


def test_without_a_forecast_it_is_said_why() -> None:
    line = Line(3, faults={'a3': '#1=abort'})
    run = ran(line, 1, 1)
    with pytest.raises(NoForecast, match='the journal knows no start of job J7'):
        looked(run, 'J7', line.cell)
    with pytest.raises(NotKept, match='does not fit cell'):
        looked(run, 'J0', Line(2).cell)


def test_both_are_seen_by_their_watchers_alone() -> None:
    run = ran(LINE, 5, slower=2.0)
    forecast, real = (GanttFold(by_component=True) for _ in range(2))
    reading = Reading(MemoryRecords(run.store))
    recap = LookingBack(reading, LINE.cell, TYPES, 'it').at('J0', Watchers([forecast], [real]))
    assert recap.real.end_us is not None
    end_s = recap.real.end_us / US
    took = {
        name: [bar.end_s - bar.start_s for row in fold.past(0.0, end_s).rows for bar in row.tasks
               if row.title == 'a2']
        for name, fold in (('forecast', forecast), ('real', real))
    }  # fmt: skip
    assert took == {'forecast': [5.0] * 5, 'real': [7.0] * 5}
