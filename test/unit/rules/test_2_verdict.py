"""Semantics 2.8: the verdict on the results of a task."""

from __future__ import annotations

from math import inf, nan
from typing import Any

import pytest
from fakes.commands import AnswerHold
from fakes.line import Line
from fakes.operator import ann
from fakes.virtual_run import VirtualRun

JUDGED = """
params: {least: {type: float, default: 4.5}}
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2:
    - id: weigh
      task: TASK_A
      action: /a2/do
      fails_unless: {value: "${results.weigh.measurement}", between: ["${params.least}", 5.5]}
      OPTIONS
    - {id: mark, @b2, runs_for: all, args: {special_argument_2: "${results.weigh.measurement}"}}
  3: [{id: pack, @a3, qty_change: -1, runs_for: all}]
"""
WEIGHED_AT = 4.0


def judged(*read: float, options: str = '', quantity: int = 1, **params: object) -> VirtualRun:
    """Run a line on which items are weighed.

    :param read: what the scale says of each attempt in turn
    """
    faults = ' '.join(f'#{n}=reads:{value}' for n, value in enumerate(read, 1))
    script = JUDGED.replace('OPTIONS', options)
    return Line(faults={'a2': faults}).run(script, quantity, **params)


def result(measurement: Any) -> dict[str, Any]:
    return {'item_present': True, 'measurement': measurement}


@pytest.mark.parametrize(
    ('read', 'refused'), [(4.5, False), (5.5, False), (4.4, True), (5.6, True)]
)
def test_2_8_result_outside_verdict_fails_attempt(read: float, *, refused: bool) -> None:
    run = judged(read)
    assert run.times('task.failed', reason='result_refused') == [WEIGHED_AT] * refused
    assert run.times('task.succeeded', task='weigh') == [WEIGHED_AT] * (not refused)
    assert run.ended is not refused


def test_2_8_hold_names_expected_and_found_values() -> None:
    run = judged(6.0, least=5.0)
    (hold,) = run.state.holds.values()
    assert hold.reason == 'result_refused'
    assert hold.message == (
        'expected ${results.weigh.measurement} from 5.0 to 5.5; found 6.0; '
        'later tasks use its results: measurement; mark_done may give them'
    )
    assert hold.answers == ('retry', 'mark_done', 'skip', 'reject', 'abort_job')


def test_2_8_of_several_values_each_is_named() -> None:
    both = '{all: ["${results.weigh.item_present}", VALUE]}'
    value = '{value: "${results.weigh.measurement}", between: ["${params.least}", 5.5]}'
    text = JUDGED.replace(value, both.replace('VALUE', value)).replace('OPTIONS', '')
    run = Line(faults={'a2': '#1=reads:6.0'}).run(text)
    (failed,) = run.all('task.failed')
    assert failed['message'] == (
        'expected ${results.weigh.item_present} and ${results.weigh.measurement} from 4.5 to 5.5; '
        'found ${results.weigh.item_present} = true, ${results.weigh.measurement} = 6.0'
    )


def test_2_8_every_reading_is_recorded() -> None:
    run = judged(6.0, 4.0, 5.0, options='retries: 2')
    assert [event['results'] for event in run.all('task.failed')] == [result(6.0), result(4.0)]
    assert [event['results'] for event in run.all('task.succeeded', task='weigh')] == [result(5.0)]
    assert [event['args'] for event in run.all('task.started', task='mark')] == [
        {'special_argument_2': 5.0}
    ]
    assert run.state.ended['J'].progress.nonconforming == 0


@pytest.mark.parametrize('value', [nan, inf, -inf])
@pytest.mark.parametrize('comparison', ['at_least: 0', 'at_most: 9'])
def test_2_8_what_is_no_finite_number_is_refused(value: float, comparison: str) -> None:
    text = JUDGED.replace('between: ["${params.least}", 5.5]', comparison).replace('OPTIONS', '')
    run = Line(results={'a2': {'measurement': value}}).run(text)
    (failed,) = run.all('task.failed')
    assert failed['reason'] == 'result_refused'
    expected = f'${{results.weigh.measurement}} is {value}, which is no finite number'
    assert failed['message'] == expected


def test_2_8_continue_keeps_the_results_for_later_tasks() -> None:
    run = judged(6.0, options='on_failure: continue')
    assert [record['args'] for record in run.all('task.started', task='mark')] == [
        {'special_argument_2': 6.0}
    ]
    assert run.ended
    assert run.state.ended['J'].progress.nonconforming == 1


def test_2_8_a_rejected_item_has_no_results_of_it() -> None:
    run = judged(6.0, options='on_failure: reject')
    assert run.reasons() == ['result_refused', 'missing_result']
    assert run.times('item.rejected') == [WEIGHED_AT]


def test_2_8_between_good_ones_the_bad_item_is_rejected() -> None:
    text = JUDGED.replace('runs_for: all, args', 'args').replace('OPTIONS', 'on_failure: reject')
    run = Line(results={'a2': {'measurement': 5.0}}, faults={'a2': '#2=reads:4.0'}).run(text, 3)
    assert run.order('item.rejected', 'item') == ['J/2']
    progress = run.state.ended['J'].progress
    assert (progress.packed, progress.rejected, progress.nonconforming) == (2, 1, 0)


@pytest.mark.parametrize(('answer', 'ends'), [('mark_done', 'marked_done'), ('skip', 'skipped')])
def test_2_8_who_lets_an_item_pass_marks_it(answer: str, ends: str) -> None:
    run = judged(6.0)
    given = {'measurement': 5.4} if answer == 'mark_done' else {}
    assert run.ask(AnswerHold('1', answer, ann('weighed by hand'), given)).accepted
    (marked,) = run.all('item.nonconforming')
    assert (marked['item'], marked['task']) == ('J/1', 'weigh')
    assert marked['reason'] == f'Ann decided {answer}: weighed by hand'
    assert run.state.items['J/1'].nonconforming == ['weigh']
    assert run.times(f'task.{ends}', task='weigh') == [WEIGHED_AT]


@pytest.mark.parametrize('answer', ['mark_done', 'skip'])
def test_2_8_aborted_attempt_without_verdict_marks_item_nonconforming(answer: str) -> None:
    run = Line(faults={'a2': '#1=abort'}).run(JUDGED.replace('OPTIONS', ''))
    run.answer(answer)
    assert run.state.items['J/1'].nonconforming == ['weigh']


def test_2_8_a_position_without_an_item_is_not_marked() -> None:
    run = judged(6.0)
    assert run.remove('J/1').accepted
    run.answer('skip')
    run.go()
    assert run.all('item.nonconforming') == []
    assert run.ended


def test_2_8_missing_result_of_other_task_prevents_start() -> None:
    text = JUDGED.replace('2:\n', '2:\n    - {id: look, @b2.TASK_B, on_failure: continue}\n')
    value = '{value: "${results.weigh.measurement}", between: ["${params.least}", 5.5]}'
    verdict = f'{{any: ["${{results.look.item_present}}", {value}]}}'
    text = text.replace(value, verdict).replace('OPTIONS', '')
    run = Line(faults={'b2': '#1=abort'}).run(text)
    assert run.reasons() == ['aborted', 'missing_result']
    assert run.starts('weigh') == []
