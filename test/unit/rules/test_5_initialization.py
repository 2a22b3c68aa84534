"""Semantics 5: initialization, and jobs back to back."""

from __future__ import annotations

import pytest
from fakes.line import THREE, Line, with_initialization
from fakes.virtual_run import VirtualRun

from bt_orchestrator.model.wait import WaitKind

HOME = with_initialization('[{id: home, task: HOME, action: /belt/do, once: true}]')


# --- 5.1 ------------------------------------------------------------------------------------


def test_5_1_what_is_not_ordered_runs_in_parallel() -> None:
    text = with_initialization('[{id: one, @a1.PREPARE}, {id: two, @a2.PREPARE}, {id: l, @lamp}]')
    run = Line().run(text)
    assert run.starts('one') == run.starts('two') == run.starts('l') == [0.0]


def test_5_1_dependencies_order_it() -> None:
    text = with_initialization(
        '[{id: one, @a1.PREPARE}, {id: two, @b1.PREPARE}, {id: three, @lamp}]',
        'initialization_dependencies:\n'
        '  - {upstream: two, downstream: one}\n'
        '  - {upstream: three, downstream: one}\n',
    )
    run = Line(seconds={'lamp': 2.0}).begin(text).go(until=1.5)
    assert run.waits()['initialization'] == 'waiting for initialization three'
    run.go()
    assert run.starts('one') == [2.0]


def test_5_1_tasks_of_one_component_run_sequentially() -> None:
    run = Line().run(with_initialization('[{id: one, @a1.PREPARE}, {id: two, @a1.TASK_B}]'))
    assert run.starts('one') == [0.0]
    assert run.starts('two') == [1.0]


def test_5_1_initialization_events_carry_no_section_and_no_item() -> None:
    run = Line().run(with_initialization('[{id: one, @a1.PREPARE}]'))
    (started,) = run.all('task.started', task='one')
    assert started['job'] == 'J'
    assert not {'section', 'item'} & started.keys()


# --- 5.2 ------------------------------------------------------------------------------------


def test_5_2_a_section_waits_for_its_own_components_only() -> None:
    text = with_initialization('[{id: two, @a2.PREPARE}, {id: three, @a3.PREPARE}]')
    run = Line(seconds={'a2': 4.0, 'a3': 30.0}).begin(text).go(until=3.0)
    assert run.starts('place') == [0.0]
    assert run.waits()['section 2'] == 'waiting for initialization two of J'
    run.go()
    assert run.starts('work') == [4.0]
    assert run.starts('pack') == [30.0]


def test_5_2_every_section_waits_for_components_of_no_section() -> None:
    text = with_initialization('[{id: light, @lamp}]')
    run = Line(seconds={'lamp': 4.0}).run(text)
    assert run.starts('place') == [4.0]


def test_5_2_component_preparation_waits_for_its_section() -> None:
    text = with_initialization('[{id: two, @a2.PREPARE}]')
    line = Line(seconds={'b3': 1.0})
    run = line.begin(text, 2)
    run.submit('K', line.script(text), 1)
    run.go(until=5.0)
    assert run.waits()['initialization'] == 'waiting for section 2 to finish J'
    run.go()
    # Section 2 ends its cycle for J/2 at 7.0; J itself ends later.
    assert run.starts('two', job='K') == [7.0]
    assert run.times('job.completed', job='J') == [10.0]


def test_5_2_shared_component_waits_for_each_section() -> None:
    text = with_initialization('[{id: arm, @arm.PREPARE}]')
    line = Line()
    run = line.begin(text, 1)
    run.submit('K', line.script(text), 1)
    run.go()
    assert run.starts('arm', job='K') == [8.0]  # section 3 is done with J


def test_5_2_source_waits_for_dependent_initialization() -> None:
    """K's item must not be placed: section 2 waits for section 3, which waits for J's item."""
    text = with_initialization(
        '[{id: two, @a2.PREPARE}, {id: three, @a3.PREPARE}]',
        'initialization_dependencies: [{upstream: three, downstream: two}]\n',
    )
    line = Line(seconds={'a3': 2.0})
    run = line.begin(text, 1)
    run.submit('K', line.script(text), 1)
    run.go()
    assert run.ended
    done_with_j = run.times('cycle.completed', job='J', section=3)
    assert run.starts('three', job='K') == done_with_j
    assert run.starts('place', job='K') == run.times('task.succeeded', job='K', task='two')


def test_5_2_job_awaiting_initialization_gives_no_turn() -> None:
    """The belt moves on with J's item while K waits for the line to drain."""
    text = with_initialization('[{id: light, @lamp}]')
    line = Line()
    run = line.begin(text, 1)
    run.submit('K', line.script(text), 1)
    run.go(until=4.0)
    assert run.waits()['section 1'] == 'waiting for initialization light of K'
    assert run.times('belt.index_started') == [2.0]
    run.go()
    assert run.starts('light', job='K') == [8.0]
    assert run.ended


@pytest.mark.parametrize('quantity', [1, 2, 5])
def test_5_2_jobs_with_different_scripts_run_back_to_back(quantity: int) -> None:
    second = """
    initialization: [{id: one, @a1.PREPARE}, {id: two, @b2.PREPARE}]
    sections:
      1: [{id: put, @a1, qty_change: 1}]
      2: [{id: press, @b2}, {id: turn, @arm}]
      3: [{id: out, @b3, qty_change: -1}]
    """
    line = Line()
    run = line.begin(HOME, quantity)
    run.submit('K', line.script(second, 'second'), quantity)
    run.submit('L', line.script(HOME), quantity)
    run.go()
    assert run.order('job.completed', 'job') == ['J', 'K', 'L']
    assert run.starts('home') == [0.0]
    assert [run.counts(job)['packed'] for job in 'JKL'] == [quantity] * 3
    # K is on the belt before J has left it.
    assert run.times('item.placed', job='K')[0] < run.times('job.completed', job='J')[0]


def test_5_2_a_failed_initialization_task_holds_its_job() -> None:
    run = Line(faults={'a1': '#1=abort'}).run(with_initialization('[{id: one, @a1.PREPARE}]'))
    (hold,) = run.state.holds.values()
    assert (hold.job, hold.section, hold.item, hold.task) == ('J', None, None, 'one')
    assert hold.answers == ('retry', 'mark_done', 'skip', 'abort_job')
    assert run.starts('place') == []
    run.answer('retry')
    run.go()
    assert run.ended


# --- 5.2, the order of jobs -----------------------------------------------------------------

PASSED = """
initialization:
  - {id: load, @a2.PREPARE, retries: 1, retry_delay: 30.0, args: {special_argument_2: 1.0}}
sections:
  1: [{id: place, @a1, qty_change: 1}]
  3: [{id: pack, @a3, qty_change: -1}]
"""
"""Its items pass section 2, for which it prepares all the same."""


def late_initialization(second: str) -> VirtualRun:
    """Run J, of which `load` succeeds at 31 s, its last item being long gone, and then K."""
    line = Line(faults={'a2': '#1=abort'})
    run = line.begin(PASSED)
    run.submit('K', line.script(second, 'second'), 2)
    return run


def test_5_2_initialization_of_component_keeps_job_order() -> None:
    """J's recipe must not be loaded over K's."""
    run = late_initialization(with_initialization('[{id: load, @a2.PREPARE}]'))
    run.go(until=20.0)
    assert run.waits()['initialization'].endswith('waiting for initialization load of J')
    run.go()
    assert run.starts('load') == [0.0, 31.0, 32.0]
    assert [record['job'] for record in run.all('task.started', task='load')] == ['J', 'J', 'K']
    assert run.starts('work', job='K')[0] == 33.0
    assert run.ended


def test_5_2_section_waits_for_initialization_of_earlier_jobs() -> None:
    """J's recipe must not be loaded in the middle of K, which prepares nothing there."""
    run = late_initialization(THREE)
    run.go(until=20.0)
    assert run.starts('place', job='K') == [3.0, 6.0]  # only section 2 waits
    assert run.waits()['section 2'] == 'waiting for initialization load of J'
    (wait,) = [part_wait.wait for part_wait in run.sim.waits() if part_wait.part == 'section 2']
    assert (wait.kind, wait.name, wait.task) == (WaitKind.INITIALIZATION, 'load', 'load')
    run.go()
    assert run.starts('work', job='K')[0] == run.times('task.succeeded', task='load')[0] == 32.0
    assert run.ended


def test_5_2_source_waits_for_initialization_of_earlier_jobs() -> None:
    """J is placed in section 2; K, whose source is section 1, must not begin before J's `load`."""
    first = PASSED.replace('@a2.PREPARE', '@a1.PREPARE').replace(
        '1: [{id: place, @a1', '2: [{id: place, @a2'
    )
    line = Line(faults={'a1': '#1=abort'})
    run = line.begin(first)
    run.submit('K', line.script(THREE, 'second'), 1)
    run.go(until=20.0)
    assert run.waits()['section 1'] == 'waiting for initialization load of J'
    run.go()
    assert run.starts('place', job='K') == [32.0]
    assert run.ended


def test_5_2_held_jobs_keep_nobody_waiting() -> None:
    line = Line()
    run = line.begin(THREE)
    text = with_initialization('[{id: load, @a2.PREPARE}]')
    run.add(('K', line.script(text, 'prepared')), held=True)
    run.add(('L', line.script(text, 'prepared')))
    run.go(until=30.0)
    assert [record['job'] for record in run.all('task.started', task='load')] == ['L']
    run.control('release', 'K')
    run.go()
    assert run.ended
