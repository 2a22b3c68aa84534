"""Semantics 6.6: the queue: orders that are added, put in order, changed, taken out, and held."""

from __future__ import annotations

import pytest
from fakes.commands import MoveJob, RunNext
from fakes.line import THREE, Line, with_section
from fakes.queued_jobs import LINE, SCRIPT, begun, queue, queued
from fakes.virtual_run import BY, VirtualRun

from bt_orchestrator.model.jobs.job_commands import UpdateJob
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.limits import ENDED_KEPT
from bt_orchestrator.model.packml import PackmlState
from bt_orchestrator.sim.simulation import Simulation
from bt_orchestrator.store.memory import MemoryStore

# --- ids and batches ------------------------------------------------------------------------


def test_6_6_an_id_is_used_once_however_long_ago() -> None:
    store = MemoryStore()
    sim = Simulation(LINE.cell, LINE.types, store)
    sim.submit(Job(name, SCRIPT, 1) for name in ('J', *(f'K{n}' for n in range(ENDED_KEPT))))
    sim.run()
    assert 'J' not in sim.state.ended, 'it is too long ago to be listed'
    again = Simulation(LINE.cell, LINE.types, store)
    for line in (sim, again):
        (answer,) = line.submit([Job('J', SCRIPT, 1)])
        assert answer.message == 'order J was given before; choose another id'
        line.close()


def test_6_6_a_removed_order_keeps_its_id() -> None:
    run = queued('K')
    run.control('remove', 'K')
    assert not run.submit('K', SCRIPT).accepted


def test_6_6_of_several_orders_all_are_queued_or_none() -> None:
    run = queued('K')
    before = len(run.records)
    answer = run.add(('L', SCRIPT), ('K', SCRIPT), ('M', SCRIPT), ('M', SCRIPT))
    assert not answer.accepted
    assert answer.each == (
        'L fits, but was not queued because of the others',
        'order K was given before; choose another id',
        'M fits, but was not queued because of the others',
        'order M was given before; choose another id',
    )
    assert queue(run) == 'K'
    recorded = run.records[before:]
    assert {(row['event'], row['command']) for row in recorded} == {('operator.refused', 'add')}
    assert [(row['job'], row['message']) for row in recorded] == list(
        zip('LKMM', answer.each, strict=True)
    )


def test_6_6_oldest_ended_job_is_cleared_at_limit() -> None:
    run = VirtualRun(LINE.cell, LINE.types)
    for number in range(ENDED_KEPT + 2):
        run.submit(f'K{number}', SCRIPT)
    run.go()
    assert list(run.state.ended) == [f'K{number}' for number in range(2, ENDED_KEPT + 2)]
    cleared = run.all('job.cleared')
    assert [record['job'] for record in cleared] == ['K0', 'K1']
    assert {record['reason'] for record in cleared} == {'the last 100 that ended are listed'}
    ends = run.all('job.completed')[-2:]
    assert [record['time'] for record in cleared] == [end['time'] for end in ends]


def test_6_6_orders_given_together_agree_on_flags() -> None:
    line = Line(4)
    scripts = [line.script(text, f's{n}') for n, text in enumerate((flagged(1), flagged(2)))]
    run = VirtualRun(line.cell, line.types).go()
    answer = run.add(('K', scripts[0]), ('L', scripts[1]))
    assert not answer.accepted
    assert 'share the flag clear but disagree' in answer.each[1]


def flagged(capacity: int) -> str:
    return f"""
    sections:
      1: [{{id: place, @a1, qty_change: 1}}]
      2: [{{id: look, @a2}}]
      3: [{{id: fix, @a3}}]
      4: [{{id: pack, @a4, qty_change: -1}}]
    lateral_dependencies:
      - {{flag: clear, upstream: look, downstream: fix, capacity: {capacity}}}
    """


# --- order ----------------------------------------------------------------------------------


def test_6_6_orders_are_put_at_a_place() -> None:
    run = queued('KL')
    answer = run.add(('X', SCRIPT), ('Y', SCRIPT), position=2)
    assert answer.message == 'X is queued\nY is queued'
    assert queue(run) == 'KXYL'
    run.go()
    assert begun(run) == list('JKXYL')


@pytest.mark.parametrize('position', [0, 4])
def test_6_6_a_place_that_is_not_there_is_refused(position: int) -> None:
    run = queued('KL')
    answer = run.add(('X', SCRIPT), position=position)
    assert answer.message == f'the position must be from 1 to 3, not {position}'


def test_6_6_a_job_is_moved() -> None:
    run = queued('KLM')
    assert run.ask(MoveJob('M', 1, BY)).message == 'M is at position 1'
    assert queue(run) == 'MKL'
    assert run.ask(MoveJob('M', 3, BY)).accepted
    assert queue(run) == 'KLM'
    run.ask(MoveJob('L', 1, BY))
    run.go()
    assert begun(run) == list('JLKM')


def test_6_6_what_has_started_is_not_in_the_queue() -> None:
    run = queued('KL')
    for command in (MoveJob('J', 1, BY), MoveJob('X', 1, BY), RunNext('J', BY)):
        assert run.ask(command).message.endswith('; in the queue: K, L')
    assert run.ask(MoveJob('K', 3, BY)).message == 'the position must be from 1 to 2, not 3'


def test_6_6_run_next_moves_job_first_and_releases_it() -> None:
    run = queued('KLM')
    run.control('hold', 'M')
    assert run.ask(RunNext('M', BY)).message == 'M is next'
    run.go()
    assert begun(run) == list('JMKL')


def test_6_6_a_removed_job_never_starts() -> None:
    run = queued('KL')
    assert run.control('remove', 'K').message == 'K is out of the queue'
    run.go()
    assert begun(run) == list('JL')
    assert 'K' not in run.state.ended


def test_6_6_preparation_follows_the_order_of_the_queue() -> None:
    prepared = LINE.script(f'initialization: [{{id: ready, @b1}}]{THREE}', 'prepared')
    run = VirtualRun(LINE.cell, LINE.types)
    run.submit('J', SCRIPT, 3)
    run.add(('K', prepared), ('L', prepared))
    run.ask(MoveJob('L', 1, BY))
    run.go()
    assert [r['job'] for r in run.all('task.started', task='ready')] == ['L', 'K']


# --- held jobs ------------------------------------------------------------------------------


def test_6_6_held_job_is_passed_and_keeps_place() -> None:
    run = queued('KLM')
    run.control('hold', 'K')
    run.go(until=9.0)
    assert queue(run) == 'KM'
    assert begun(run) == list('JL')
    run.control('release', 'K')
    run.go()
    assert begun(run) == list('JLKM')


def test_6_6_released_job_follows_started_jobs() -> None:
    run = VirtualRun(LINE.cell, LINE.types)
    run.add(('K', SCRIPT), held=True)
    run.submit('J', SCRIPT, 3)
    run.go(until=1.5)
    run.control('release', 'K')
    assert list(run.state.jobs) == ['J', 'K']
    run.go()
    assert run.order('item.placed', 'item') == ['J/1', 'J/2', 'J/3', 'K/1']


def test_6_6_a_held_job_prepares_nothing() -> None:
    prepared = LINE.script(f'initialization: [{{id: ready, @lamp}}]{THREE}', 'prepared')
    run = VirtualRun(LINE.cell, LINE.types)
    assert run.add(('K', prepared), held=True).message == 'K is queued and held'
    run.add(('L', SCRIPT))
    run.go()
    assert run.starts('ready') == []
    assert run.state.packml is PackmlState.COMPLETE, 'there is nothing to be done'
    run.control('release', 'K')
    run.go()
    assert run.ended


def test_6_6_held_jobs_alone_do_not_start_the_cell() -> None:
    run = VirtualRun(LINE.cell, LINE.types)
    run.add(('K', SCRIPT), held=True)
    run.go()
    assert run.state.packml is PackmlState.STOPPED
    assert run.waits()['section 1'].startswith('the cell is Stopped')
    run.control('release', 'K')
    run.go()
    assert run.ended


# --- changes --------------------------------------------------------------------------------


def test_6_6_a_queued_job_is_changed() -> None:
    run = queued('KL')
    press = LINE.script(with_section(2, '- {id: press, @b2}'), 'press')
    assert run.ask(UpdateJob(Job('K', press, 2, {}), BY)).message == 'K is updated'
    assert queue(run) == 'KL'
    run.go()
    assert [r['item'] for r in run.all('task.started', task='press')] == ['K/1', 'K/2']


def test_6_6_update_must_match_flags_of_other_jobs() -> None:
    line = Line(4)
    run = VirtualRun(line.cell, line.types)
    run.submit('J', line.script(flagged(1), 'one'), 3)
    run.add(('K', line.script(flagged(1), 'one')))
    answer = run.ask(UpdateJob(Job('K', line.script(flagged(2), 'two'), 1, {}), BY))
    assert 'share the flag clear but disagree' in answer.message
    run.go()
    assert run.ended


def test_6_6_update_may_contradict_own_old_flags() -> None:
    line = Line(4)
    run = VirtualRun(line.cell, line.types)
    run.add(('K', line.script(flagged(1), 'one')), held=True)
    assert run.ask(UpdateJob(Job('K', line.script(flagged(2), 'two'), 1, {}), BY)).accepted
    assert run.state.flags['clear'].capacity == 2
    run.control('release', 'K')
    run.go()
    assert run.ended


def test_6_6_changed_initialization_is_done_in_whole() -> None:
    once = f'initialization: [{{id: home, @a1.PREPARE, once: true}}]{THREE}'
    other = f'initialization: [{{id: home, @a1.TASK_B, once: true}}]{THREE}'
    run = VirtualRun(LINE.cell, LINE.types)
    run.submit('J', LINE.script(once, 'once'), 3)
    run.go(until=4.0)
    run.add(('K', LINE.script(once, 'once')))  # its `home` is skipped at once
    run.ask(UpdateJob(Job('K', LINE.script(other, 'other'), 1, {}), BY))
    run.go()
    done = [(r['job'], r['name']) for r in run.all('task.started', task='home')]
    assert done == [('J', 'PREPARE'), ('K', 'TASK_B')]
