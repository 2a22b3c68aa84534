"""Semantics 6: jobs, counts, results, rejected items, conditions."""

from __future__ import annotations

from math import inf, nan

import pytest
from fakes.commands import AnswerHold
from fakes.line import THREE, Line, with_section
from fakes.operator import ann

from bt_orchestrator.model.requests import BadArguments, ask

# --- 6.1 ------------------------------------------------------------------------------------


def test_6_1_jobs_are_worked_in_the_order_queued() -> None:
    line = Line()
    run = line.begin(THREE, 2)
    for name in 'KL':
        run.submit(name, line.script(THREE), 2)
    run.go()
    placed = run.order('item.placed', 'item')
    assert placed == ['J/1', 'J/2', 'K/1', 'K/2', 'L/1', 'L/2']
    assert run.starts('place') == [0.0, 3.0, 6.0, 9.0, 12.0, 15.0]


def test_6_1_section_works_on_job_of_its_item() -> None:
    other = THREE.replace('id: work, @a2', 'id: press, @b2')
    line = Line()
    run = line.begin(THREE, 1)
    run.submit('K', line.script(other, 'other'), 1)
    run.go()
    assert run.starts('pack', item='J/1') == [6.0]
    assert run.starts('press', item='K/1') == [6.0]


def test_6_1_job_leaves_queue_and_ends_without_remaining_work() -> None:
    line = Line()
    run = line.begin(THREE, 1)
    run.submit('K', line.script(THREE), 1)
    run.go()
    assert run.times('job.started') == [0.0, 1.0]  # K's first cycle begins ahead of its beat
    assert run.times('job.completed') == [7.0, 10.0]
    assert list(run.state.ended) == ['J', 'K']


def test_6_1_a_job_is_complete_when_its_initialization_is() -> None:
    text = f'initialization: [{{id: light, @b3}}]\n{THREE}'
    run = Line(seconds={'b3': 20.0}).run(text)
    assert run.starts('pack') == [20.0]
    assert run.times('job.completed') == [21.0]


DOWNSTREAM = """
sections:
  2: [{id: place, @a2, qty_change: 1}]
  3: [{id: work, @a3}]
  4: [{id: pack, @a4, qty_change: -1}]
"""
"""A line whose source is the second section."""


def test_6_1_upstream_item_waits_behind_item_begun_ahead() -> None:
    line = Line(4, seconds={'a3': 9.0})
    run = line.begin(DOWNSTREAM, 3)
    upstream = DOWNSTREAM.replace('2: [{id: place, @a2,', '1: [{id: place, @a1,')
    run.submit('K', line.script(upstream, 'upstream'), 1)
    run.go(until=5.0)  # section 3 works on J/1, and J/3 is begun for the next beat
    assert run.waits()['section 1'] == 'waiting for section 2 to place J/3'
    run.go()
    assert run.all('hold.raised') == []
    assert [run.all('cycle.started', item=item)[0]['beat'] for item in ('J/3', 'K/1')] == [3, 3]
    assert run.times('job.completed', job='K') == [48.0]


def test_6_1_section_leaves_job_after_trailing_steps() -> None:
    text = with_section(
        2,
        """
          release_conveyor: after_last_conveyor_task
          tasks: [{id: work, @a2}, {id: clean, @b2, requires_conveyor: false}]
        """,
    )
    line = Line(seconds={'b2': 9.0})
    run = line.begin(text)
    run.submit('K', line.script(f'initialization: [{{id: ready, @a2}}]{THREE}', 'second'))
    run.go()
    assert run.times('cycle.completed', section=2, job='J') == run.starts('ready') == [13.0]


# --- 6.2 ------------------------------------------------------------------------------------


@pytest.mark.parametrize('quantity', [1, 4])
def test_6_2_quantity_is_the_number_of_source_cycles(quantity: int) -> None:
    run = Line().run(quantity=quantity)
    assert len(run.all('cycle.started', section=1)) == quantity
    assert run.counts() == dict.fromkeys(('started', 'placed', 'processed', 'packed'), quantity)


def test_6_2_progress_counts_as_it_happens() -> None:
    run = Line().begin(quantity=3).go(until=7.0)
    assert run.counts() == {'started': 3, 'placed': 3, 'processed': 2, 'packed': 1}


def test_6_2_rejected_nonconforming_item_counts_as_rejected() -> None:
    text = """
    sections:
      1: [{id: place, @a1, qty_change: 1}]
      2: [{id: work, @a2, on_failure: continue}]
      3: [{id: test, @a3, on_failure: reject}]
      4: [{id: pack, @a4, qty_change: -1, runs_for: all}]
    """
    run = Line(4, faults={'a2': '#1=abort #2=abort', 'a3': '#1=abort'}).run(text, 3)
    counts = {'started': 3, 'placed': 3, 'processed': 2, 'packed': 2, 'rejected': 1}
    assert run.counts() == {**counts, 'nonconforming': 1}
    assert run.job().progress.good == 1


def test_6_2_counts_of_a_line_where_everything_happens() -> None:
    text = """
    sections:
      1: [{id: place, @a1, qty_change: 1, on_failure: continue}]
      2: [{id: work, @a2, on_failure: continue}]
      3: [{id: test, @a3, on_failure: reject}]
      4: [{id: pack, @a4, qty_change: -1, runs_for: all}]
    """
    line = Line(4, faults={'a1': '#2=abort', 'a2': '#2=abort', 'a3': '#3=abort'})
    run = line.begin(text, 6).go(until=16.0)
    # Item 2 was never placed; `work` failed for item 3; `test` for item 4. Only item 3 is packed
    # and nonconforming.
    assert run.remove('J/5').accepted
    run.go()
    assert run.counts() == {
        'started': 6,
        'placed': 5,
        'processed': 3,
        'packed': 3,
        'rejected': 1,
        'nonconforming': 1,
        'missing': 2,
        'removed': 1,
    }


# --- 6.3 ------------------------------------------------------------------------------------

MEASURED = """
params: {label: {type: str, default: none}}
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2: [{id: look, @a2}]
  3:
    - id: use
      task: TASK_A
      action: /a3/do
      args:
        special_argument_1: "${order.id} of ${order.quantity}: ${item.number} ${params.label}"
        special_argument_2: "${results.look.measurement}"
    - {id: pack, @b3, qty_change: -1}
"""


def test_6_3_results_travel_with_the_item() -> None:
    run = Line(results={'a2': {'measurement': 7.25}}).run(MEASURED, 2, label='A7')
    given = [record['args'] for record in run.all('task.started', task='use')]
    assert given == [
        {'special_argument_1': 'J of 2: 1 A7', 'special_argument_2': 7.25},
        {'special_argument_1': 'J of 2: 2 A7', 'special_argument_2': 7.25},
    ]


def test_6_3_task_ignores_results_of_other_items() -> None:
    text = MEASURED.replace('id: look, @a2', 'id: look, @a2, on_failure: continue')
    run = Line(faults={'a2': '#2=abort'}).run(text, 2)
    assert run.reasons() == ['aborted', 'missing_result']
    (hold,) = run.state.holds.values()
    assert (hold.item, hold.task, hold.reason) == ('J/2', 'use', 'missing_result')
    run.answer('skip')
    run.go()
    assert run.ended


def test_6_3_a_task_marked_done_has_no_results() -> None:
    run = Line(faults={'a2': '#1=abort'}).run(MEASURED)
    run.answer('mark_done')
    run.go()
    assert run.reasons() == ['aborted', 'missing_result']


def test_6_3_the_hold_says_which_results_later_tasks_use() -> None:
    run = Line(faults={'a2': '#1=abort'}).run(MEASURED)
    (hold,) = run.state.holds.values()
    wanted = 'later tasks use its results: measurement; mark_done may give them'
    assert hold.message.endswith(wanted)


def test_6_3_task_marked_done_has_operator_results() -> None:
    run = Line(faults={'a2': '#1=abort'}).run(MEASURED)
    given = run.ask(AnswerHold('1', 'mark_done', ann(), {'measurement': 3.5}))
    assert given.accepted
    run.go()
    assert run.ended
    (marked,) = run.all('task.marked_done')
    assert marked['results'] == {'measurement': 3.5}
    (used,) = run.all('task.started', task='use')
    assert used['args']['special_argument_2'] == 3.5


@pytest.mark.parametrize('answer', ['retry', 'skip'])
def test_6_3_results_go_with_mark_done_only(answer: str) -> None:
    with pytest.raises(BadArguments, match=f'hold.{answer} takes hold, code; found results'):
        ask(f'hold.{answer}', ann(), hold='1', results={'measurement': 3.5})


# --- 6.4 ------------------------------------------------------------------------------------


def test_6_4_the_remaining_tasks_skip_a_rejected_item() -> None:
    text = """
    sections:
      1: [{id: place, @a1, qty_change: 1}]
      2:
        - {id: test, @a2, on_failure: reject}
        - {id: good, @b2}
        - {id: bad, @b2.TASK_B, runs_for: rejected}
        - {id: both, @b2.TASK_C, runs_for: all}
      3: [{id: pack, @a3, qty_change: -1, runs_for: all}]
    """
    run = Line(faults={'a2': '#2=abort'}).run(text, 2)
    ran = {(r['item'], r['task']) for r in run.all('task.started', section=2)}
    assert ran == {
        ('J/1', 'test'),
        ('J/1', 'good'),
        ('J/1', 'both'),
        ('J/2', 'test'),
        ('J/2', 'bad'),
        ('J/2', 'both'),
    }
    assert [r['reason'] for r in run.all('task.skipped')] == ['good item', 'rejected item']
    assert run.times('item.moved', item='J/2', section=3) == [13.0]


def test_6_4_an_item_is_rejected_once() -> None:
    text = """
    sections:
      1: [{id: place, @a1, qty_change: 1}]
      2: [parallel: [{id: one, @a2, on_failure: reject}, {id: two, @b2, on_failure: reject}]]
      3: [{id: pack, @a3, qty_change: -1, runs_for: all}]
    """
    run = Line(faults={'a2': '#1=abort', 'b2': '#1=abort'}).run(text)
    assert run.order('item.rejected', 'item') == ['J/1']
    assert run.counts()['rejected'] == 1


def test_6_4_rejected_item_gets_no_further_attempt() -> None:
    text = """
    sections:
      1: [{id: place, @a1, qty_change: 1}]
      2:
        - parallel:
          - {id: one, @a2, on_failure: reject}
          - {id: two, @b2, retries: 3, retry_delay: 5.0}
      3: [{id: pack, @a3, qty_change: -1, runs_for: all}]
    """
    run = Line(faults={'a2': '#1=abort', 'b2': '#1=abort'}).run(text)
    assert run.starts('two') == [3.0]
    assert run.order('task.skipped') == ['two']


# --- 6.5 ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ('condition', 'runs'),
    [
        ('when: "${params.wanted}"', True),
        ('unless: "${params.wanted}"', False),
        ('when: {value: "${params.kind}", equals: tall}', True),
        ('when: {value: "${params.kind}", equals: small}', False),
        ('unless: {value: "${params.kind}", equals: small}', True),
        ('when: {value: "${item.number}", equals: 1}', True),
        ('when: {value: "${results.look.item_present}", equals: false}', False),
    ],
)
def test_6_5_a_condition_skips_a_task(condition: str, runs: bool) -> None:
    text = 'params: {wanted: {type: bool}, kind: {type: str}}' + with_section(
        2, f'[{{id: look, @a2}}, {{id: work, @b2, {condition}}}]'
    )
    run = Line().run(text, wanted=True, kind='tall')
    assert bool(run.starts('work')) is runs
    assert run.times('task.skipped', task='work') == ([] if runs else [4.0])
    assert run.ended


def test_6_5_condition_on_missing_result_ends_attempt() -> None:
    text = with_section(
        2,
        """
        - {id: look, @a2, on_failure: continue}
        - {id: work, @b2, when: "${results.look.item_present}"}
        """,
    )
    run = Line(faults={'a2': '#1=abort'}).run(text)
    assert run.reasons() == ['aborted', 'missing_result']


WEIGHED = """
params:
  least: {type: float, default: 1.0}
  kind: {type: str, default: tall}
  n: {type: int, default: 2}
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2: [{id: look, @a2}]
  3: [{id: work, @b3, CONDITION}, {id: pack, @a3, qty_change: -1}]
"""
WEIGHT = '{value: "${results.look.measurement}", '


def weighed(condition: str) -> str:
    return WEIGHED.replace('CONDITION', condition)


@pytest.mark.parametrize(
    ('condition', 'runs'),
    [
        (f'when: {WEIGHT}at_least: 2.5}}', True),
        (f'when: {WEIGHT}at_least: 2.6}}', False),
        (f'when: {WEIGHT}at_most: 2.5}}', True),
        (f'when: {WEIGHT}at_most: 2.4}}', False),
        (f'when: {WEIGHT}between: [2.5, 3]}}', True),
        (f'when: {WEIGHT}between: [2, 2.5]}}', True),
        (f'when: {WEIGHT}between: [2.6, 3]}}', False),
        (f'when: {WEIGHT}between: [2, 2.4]}}', False),
        (f'unless: {WEIGHT}between: ["${{params.least}}", "${{params.n}}"]}}', True),
        ('when: {value: "${params.kind}", not_equals: small}', True),
        ('when: {value: "${params.kind}", not_equals: tall}', False),
        ('when: {value: "${item.number}", not_equals: 0}', True),
        ('when: {value: "${params.kind}", one_of: [small, tall]}', True),
        ('unless: {value: "${params.n}", one_of: [1, 2]}', False),
        ('when: {value: "${params.n}", one_of: [0, 1]}', False),
        (f'when: {{all: ["${{results.look.item_present}}", {WEIGHT}at_least: 3}}]}}', False),
        (f'when: {{all: ["${{results.look.item_present}}", {WEIGHT}at_least: 2}}]}}', True),
        (f'when: {{any: ["${{results.look.item_present}}", {WEIGHT}at_least: 3}}]}}', True),
        (f'unless: {{any: [{WEIGHT}at_most: 2}}, {WEIGHT}at_least: 3}}]}}', True),
    ],
)
def test_6_5_values_are_compared(condition: str, runs: bool) -> None:
    run = Line(results={'a2': {'measurement': 2.5}}).run(weighed(condition))
    assert bool(run.starts('work')) is runs
    assert run.ended


@pytest.mark.parametrize('value', [nan, inf, -inf])
@pytest.mark.parametrize(
    'condition',
    [
        f'when: {WEIGHT}at_least: 2.5}}',
        f'unless: {WEIGHT}at_most: 2.5}}',
        'when: {value: "a ${results.look.measurement}", not_equals: b}',
        f'when: {{any: ["${{results.look.item_present}}", {WEIGHT}at_least: 3}}]}}',
    ],
)
def test_6_5_what_is_no_finite_number_meets_no_condition(condition: str, value: float) -> None:
    run = Line(results={'a2': {'measurement': value}}).run(weighed(condition))
    assert run.reasons() == ['missing_result']
    (hold,) = run.state.holds.values()
    assert hold.message == f'${{results.look.measurement}} is {value}, which is no finite number'


@pytest.mark.parametrize('joint', ['all', 'any'])
def test_6_5_no_other_part_hides_a_missing_result(joint: str) -> None:
    text = weighed(
        f'when: {{{joint}: [{{value: "${{params.n}}", at_least: NUMBER}}, {WEIGHT}at_least: 3}}]}}'
    ).replace('id: look, @a2', 'id: look, @a2, on_failure: continue')
    for number in (1, 3):
        run = Line(faults={'a2': '#1=abort'}).run(text.replace('NUMBER', str(number)))
        assert run.reasons() == ['aborted', 'missing_result']


def test_6_5_order_parameter_serves_as_bound() -> None:
    line = Line(results={'a2': {'measurement': 2.5}})
    text = weighed(f'when: {WEIGHT}at_least: "${{params.least}}"}}')
    assert line.run(text, least=2.5).starts('work')
    assert not line.run(text, least=2.6).starts('work')
