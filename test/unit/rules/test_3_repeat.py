"""Semantics 3.9: tasks that are done again while a verdict refuses the result."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from fakes.commands import Stop
from fakes.line import Line
from fakes.virtual_run import VirtualRun

from bt_orchestrator.model.events import TaskKey
from bt_orchestrator.model.failures import may_repeat

REWORK = """
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2:
    - repeat:
        - {id: glue, @b2}
        - id: weigh
          task: TASK_A
          action: /a2/do
          fails_unless: {value: "${results.weigh.measurement}", at_least: 1.0}
          OPTIONS
      times: 2
    - {id: use, @b2.TASK_B, args: {special_argument_2: "${results.weigh.measurement}"}}
  3: [{id: pack, @a3, qty_change: -1, runs_for: all}]
"""
BEGINS = 3.0
"""Seconds at which section 2 begins with the first item; each task takes one."""


def reworked(
    *read: float, options: str = '', quantity: int = 1, faults: str = '', until: float = 1e6
) -> VirtualRun:
    """Run a line that glues and weighs an item until it weighs enough.

    :param read: what the scale says of each attempt in turn
    """
    spec = ' '.join([faults, *(f'#{n}=reads:{value}' for n, value in enumerate(read, 1))])
    run = Line(faults={'a2': spec.strip()}).begin(REWORK.replace('OPTIONS', options), quantity)
    return run.go(until=until)


def rounds(run: VirtualRun) -> list[tuple[float, int]]:
    return [(record['time'], record['n']) for record in run.all('round.begun')]


def test_3_9_a_refused_result_begins_another_round_at_once() -> None:
    run = reworked(0.0, 0.5, 1.0)
    assert rounds(run) == [(5.0, 1), (7.0, 2)]
    assert run.starts('glue') == [3.0, 5.0, 7.0]
    assert run.starts('weigh') == [4.0, 6.0, 8.0]
    assert [record.get('round') for record in run.all('task.started', task='glue')] == [None, 1, 2]
    (begun, _) = run.all('round.begun')
    assert (begun['repeat'], begun['tasks']) == ('glue', ['glue', 'weigh'])
    assert run.ended
    assert run.counts() == {'started': 1, 'placed': 1, 'processed': 1, 'packed': 1}


def test_3_9_later_tasks_use_results_of_last_round() -> None:
    run = reworked(0.0, 1.5)
    (used,) = run.all('task.started', task='use')
    assert used['args'] == {'special_argument_2': 1.5}


def test_3_9_after_the_last_round_on_failure_decides() -> None:
    run = reworked(0.0, 0.0, 0.0, options='on_failure: reject\n          retries: 3')
    assert len(rounds(run)) == 2
    assert run.all('task.retrying') == []
    assert run.times('item.rejected') == [9.0]
    assert run.counts()['rejected'] == 1


def test_3_9_round_resets_attempts_and_uses_no_retry() -> None:
    run = reworked(0.0, 1.0, options='retries: 5')
    attempts = [record['attempt'] for record in run.all('task.started', task='weigh')]
    assert attempts == [1, 1]
    assert run.all('task.retrying') == []


def test_3_9_other_failures_are_retried_in_their_round() -> None:
    run = reworked(faults='#1=abort #2=reads:0.0 #3=abort #4=reads:1.0', options='retries: 1')
    assert len(rounds(run)) == 1
    attempts = [
        (goal.get('round', 0), goal['attempt']) for goal in run.all('task.started', task='weigh')
    ]
    assert attempts == [(0, 1), (0, 2), (1, 1), (1, 2)]


def test_3_9_each_item_has_its_own_rounds() -> None:
    run = reworked(0.0, 0.0, 1.0, 0.0, 0.0, 1.0, quantity=2)
    assert [(record['item'], record['n']) for record in run.all('round.begun')] == [
        ('J/1', 1),
        ('J/1', 2),
        ('J/2', 1),
        ('J/2', 2),
    ]
    assert run.counts()['packed'] == 2


def test_3_9_again_begins_one_round_more() -> None:
    run = reworked(0.0, 0.0, 0.0, 1.0)
    (hold,) = run.state.holds.values()
    assert hold.answers == ('retry', 'again', 'mark_done', 'skip', 'reject', 'abort_job')
    assert run.answer('again').accepted
    run.go()
    assert rounds(run)[-1] == (9.0, 3)
    assert run.starts('glue')[-1] == 9.0
    assert run.ended


FOR_ALL = REWORK.replace('{id: glue, @b2}', '{id: glue, @b2, runs_for: all}').replace(
    '    - repeat:', '    - {id: look, @arm, on_failure: reject}\n    - repeat:'
)
WEIGHED = 'runs_for: all, retries: 3'


def held_rejected() -> VirtualRun:
    """Run until a rejected item is held in a repeat that runs for it."""
    text = FOR_ALL.replace('OPTIONS', WEIGHED.replace(', ', '\n          '))
    return Line(faults={'arm': '#1=abort', 'a2': '#1=reads:0.0 #2=reads:0.0'}).run(text)


def test_3_9_task_for_rejected_items_begins_no_round() -> None:
    """The policy decides at once, without retries."""
    run = held_rejected()
    (hold,) = run.state.holds.values()
    assert not rounds(run)
    assert not run.all('task.retrying')
    assert hold.answers == ('retry', 'mark_done', 'skip', 'abort_job')
    assert hold.answers_why.startswith('no again: rounds are for good items; ')
    run.answer('retry')
    run.go()
    assert (run.starts('glue'), len(run.starts('weigh'))) == ([4.0], 2)
    assert [open_hold.reason for open_hold in run.state.holds.values()] == ['result_refused']


BEHIND = """
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2: [{id: work, @a2}]
  3:
    - {id: pack, @a3, qty_change: -1, runs_for: all}
    - repeat:
        - id: weigh
          task: TASK_A
          action: /b3/do
          fails_unless: {value: "${results.weigh.measurement}", at_least: 1.0}
"""


def test_3_9_packed_item_repeats_until_job_is_aborted() -> None:
    run = Line(faults={'b3': '#1=reads:0.0 #2=reads:0.0'}).run(BEHIND)
    assert [n for _, n in rounds(run)] == [1]
    (hold,) = run.state.holds.values()
    assert 'again' in hold.answers
    run.control('abort', 'J')
    (hold,) = run.state.holds.values()
    assert hold.answers == ('retry', 'mark_done', 'skip')
    assert 'no again or abort_job: the job is being aborted' in hold.answers_why


def test_2_8_packed_item_becomes_nonconforming_without_count() -> None:
    run = Line(faults={'b3': '#1=reads:0.0 #2=reads:0.0'}).run(BEHIND)
    run.answer('mark_done')
    run.go()
    assert [record['item'] for record in run.all('item.nonconforming')] == ['J/1']
    assert run.counts() == {'started': 1, 'placed': 1, 'processed': 1, 'packed': 1}


def test_3_9_again_is_recorded_at_once_under_a_pause() -> None:
    run = reworked(0.0, 0.0, 0.0, 1.0, until=10.0)
    run.pause()
    (hold,) = (open_hold.id for open_hold in run.state.holds.values() if open_hold.task)
    assert run.answer('again', hold).accepted
    now = run.now
    run.go(until=20.0)
    assert rounds(run)[-1] == (now, 3)
    assert len(run.starts('glue')) == 3
    run.sim.clock.call_at(30.0, lambda: None)
    run.go(until=30.0)
    run.resume()
    assert run.starts('glue')[-1] == run.now > now


def test_3_3_repeat_requires_conveyor_if_any_task_does() -> None:
    text = REWORK.replace('{id: glue, @b2}', '{id: glue, @b2, requires_conveyor: false}')
    run = Line(faults={'a2': '#1=reads:1.0'}).run(text.replace('OPTIONS', ''))
    assert run.starts('glue') == [BEGINS]
    free = text.replace('OPTIONS', 'requires_conveyor: false')
    run = Line(faults={'a2': '#1=reads:1.0'}).run(free)
    assert run.starts('glue') == [1.0]  # while the belt moves


def test_3_9_retry_repeats_task_and_skip_passes_it() -> None:
    run = reworked(0.0, 0.0, 0.0, 0.0)
    assert run.answer('retry').accepted
    run.go()
    assert run.starts('weigh')[-1] == 9.0
    assert len(run.starts('glue')) == 3
    assert run.answer('skip').accepted
    run.go()
    assert len(rounds(run)) == 2
    assert run.reasons()[-1] == 'missing_result'  # of `use`


def test_3_9_every_task_of_repeat_offers_again() -> None:
    line = Line(faults={'b2': '#1=abort'}, results={'a2': {'measurement': 2.0}})
    run = line.run(REWORK.replace('OPTIONS', ''))
    assert run.state.reserved['b2'].task == 'glue', 'a held task keeps its component'
    assert run.answer('again').accepted
    run.go()
    assert rounds(run) == [(4.0, 1)]
    assert run.ended


def test_3_9_a_round_frees_what_a_held_task_kept() -> None:
    text = REWORK.replace('OPTIONS', '').replace('{id: glue, @b2}', '{id: glue, @a2.TASK_B}')
    run = Line(faults={'a2': ' '.join(f'TASK_A#{n}=reads:0' for n in (1, 2, 3))}).run(text)
    assert run.answer('again').accepted
    run.go()
    assert len(run.starts('glue')) == 4


def test_3_9_round_forgets_results_of_previous_round() -> None:
    text = REWORK.replace('OPTIONS', '').replace('glue, @b2', 'glue, @b2, on_failure: continue')
    text = text.replace('results.weigh.measurement}"}}', 'results.glue.measurement}"}}')
    run = Line(
        faults={'a2': '#1=reads:0', 'b2': '#2=abort'}, results={'a2': {'measurement': 2.0}}
    ).run(text)
    assert run.reasons() == ['result_refused', 'aborted', 'missing_result']


def test_3_9_goal_marked_for_cancel_begins_no_round() -> None:
    run = reworked(0.0, 1.0, until=4.5)
    assert run.pause().accepted
    run.go()
    key = TaskKey('J', 2, 'J/1', 'weigh')
    task = run.state.task(key)
    assert task is not None
    assert may_repeat(run.state, key, task)
    run.state.tasks[key] = replace(run.state.tasks[key], cancel_cause='timeout')
    assert not may_repeat(run.state, key, task)


def test_3_9_removed_item_begins_no_round() -> None:
    run = reworked(0.0, 1.0, until=4.5)
    assert run.remove('J/1').accepted
    run.go()
    assert rounds(run) == []
    assert run.reasons() == ['result_refused']


def test_3_9_no_round_for_a_job_that_is_aborted() -> None:
    run = reworked(0.0, 1.0, until=3.5)
    assert run.control('abort', 'J').accepted
    run.go()
    assert rounds(run) == []
    assert run.ended


def test_3_9_a_pause_begins_none() -> None:
    run = reworked(0.0, 1.0, until=4.5)
    assert run.pause().accepted
    run.go()
    assert rounds(run) == []
    assert 'paused' in run.waits()['section 2']
    assert run.resume().accepted
    run.go()
    assert rounds(run) == [(5.0, 1)]
    assert run.ended


def test_3_9_stop_lets_current_cycle_finish_rounds() -> None:
    run = reworked(0.0, 1.0, until=4.5)
    assert run.command(Stop).accepted
    run.go()
    assert rounds(run) == [(5.0, 1)]
    assert run.times('cycle.completed', section=2) == [8.0]


@pytest.mark.parametrize(('options', 'begins'), [('', 3.0), (', requires_conveyor: false', 1.0)])
def test_3_9_a_repeat_may_lead(options: str, begins: float) -> None:
    text = REWORK.replace('OPTIONS', '').replace('action: /a2/do', f'action: /a2/do{options}')
    text = text.replace('action: /a2/do, ', 'action: /a2/do\n          ')
    text = text.replace('{id: glue, @b2}', f'{{id: glue, @b2{options}}}')
    run = Line(results={'a2': {'measurement': 2.0}}).run(text)
    assert run.starts('glue') == [begins]


GROUP = """
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2:
    - parallel:
        - repeat:
            - id: weigh
              task: TASK_A
              action: /a2/do
              fails_unless: {value: "${results.weigh.measurement}", at_least: 1.0}
        - {id: other, @b2, OTHER}
  3: [{id: pack, @a3, qty_change: -1, runs_for: all}]
"""


def in_group(other: str, **line: Any) -> VirtualRun:
    return Line(seconds={'b2': 0.5}, **line).run(GROUP.replace('OTHER', other))


def test_3_9_a_repeat_is_one_track_of_a_group() -> None:
    run = in_group('retries: 0', faults={'a2': '#1=reads:0 #2=reads:2'})
    assert run.starts('weigh') == [3.0, 4.0]
    assert run.starts('other') == [3.0]
    assert run.ended


def test_3_9_item_rejected_in_group_begins_no_round() -> None:
    run = in_group('on_failure: reject', faults={'a2': '#1=reads:0', 'b2': '#1=abort'})
    assert rounds(run) == []
    assert run.times('item.rejected') == [3.5]
    assert run.reasons() == ['aborted', 'result_refused']


def test_3_9_a_hold_beside_it_keeps_the_round_waiting() -> None:
    run = in_group('retries: 0', faults={'a2': '#1=reads:0 #2=reads:2', 'b2': '#1=abort'})
    assert rounds(run) == []
    assert run.answer('mark_done').accepted
    run.go()
    assert rounds(run) == [(4.0, 1)]
    assert run.ended
