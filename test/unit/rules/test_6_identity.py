"""Semantics 6.8 and 6.9: the serial of an item, and the lots that go into it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pytest
from fakes.commands import AnswerHold
from fakes.line import expanded
from fakes.operator import ann
from fakes.reading import TYPES, Reading
from fakes.virtual_run import VirtualRun

from bt_orchestrator.script.script_file import parse_script


def serials(run: VirtualRun) -> list[tuple[str, str]]:
    return [(record['item'], record['serial']) for record in run.all('item.identified')]


def test_6_8_read_value_becomes_serial_of_item() -> None:
    run = Reading().go(2)
    assert serials(run) == [('J/1', 'S-1'), ('J/2', 'S-2')]
    assert run.ended


@pytest.mark.parametrize(
    ('field', 'serial', 'count', 'expected'),
    [
        ('code', '', 0, []),
        ('code', '  ', 0, []),
        ('code', ' 4711 ', 0, [('J/1', '4711')]),
        ('count', 'S', 0, []),
        ('count', 'S', 4711, [('J/1', '4711')]),
        ('pose.frame', 'S', 0, []),
    ],
)
def test_6_8_what_was_not_set_is_no_serial(
    field: str, serial: str, count: int, expected: list[tuple[str, str]]
) -> None:
    run = Reading(serial, count=count).go(field=field)
    assert serials(run) == expected
    assert run.ended


@pytest.mark.parametrize('policy', ['hold', 'continue', 'reject', 'abort_job'])
def test_6_8_duplicate_serial_holds_under_any_policy(policy: str) -> None:
    run = Reading('S').go(2, f', on_failure: {policy}, retries: 2')
    (failed,) = run.all('task.failed')
    assert (failed['item'], failed['reason']) == ('J/2', 'duplicate_serial')
    assert failed['results']['code'] == 'S'
    (hold,) = run.state.holds.values()
    assert hold.reason == 'duplicate_serial'
    assert hold.answers == ('retry', 'mark_done', 'skip', 'reject', 'abort_job')
    assert hold.message == (
        "the serial 'S' is of J/1, which is in work; if this is the same item again, mark_done "
        'with the result code=S'
    )
    assert serials(run) == [('J/1', 'S')]


def test_6_8_read_again_it_may_be_another_one() -> None:
    run = Reading(faults='"#2=reads:1"').go(2)
    run.answer('retry')
    run.go()
    assert serials(run) == [('J/1', 'S-1'), ('J/2', 'S-3')]
    assert run.ended


@pytest.mark.parametrize(
    ('answer', 'given', 'expected'),
    [
        ('mark_done', {'code': 'S'}, [('J/1', 'S'), ('J/2', 'S')]),
        ('mark_done', {'code': 'T'}, [('J/1', 'S'), ('J/2', 'T')]),
        ('mark_done', {}, [('J/1', 'S')]),
        ('skip', {}, [('J/1', 'S')]),
        ('reject', {}, [('J/1', 'S')]),
        ('abort_job', {}, [('J/1', 'S')]),
    ],
)
def test_6_8_the_answer_of_a_person_counts(
    answer: str, given: Mapping[str, Any], expected: list[tuple[str, str]]
) -> None:
    run = Reading('S').go(2)
    assert run.ask(AnswerHold('1', answer, ann('seen'), given)).accepted
    run.go()
    assert serials(run) == expected
    assert run.ended


def test_6_8_serial_from_person_has_length_limit() -> None:
    run = Reading('S').go(2)
    refused = run.ask(AnswerHold('1', 'mark_done', ann('seen'), {'code': 'x' * 201}))
    assert not refused.accepted
    assert refused.message == 'expected a serial of at most 200 characters; found 201'
    assert len(run.state.holds) == 1


def test_6_8_a_serial_that_is_too_long_is_refused() -> None:
    run = Reading('x' * 201).go(options=', on_failure: reject')
    (failed,) = run.all('task.failed')
    assert failed['reason'] == 'result_refused'
    assert failed['message'] == 'expected a serial of at most 200 characters; found 201'
    assert run.order('item.rejected', 'item') == ['J/1']


def test_6_8_the_verdict_comes_first() -> None:
    parts = '{value: "${results.read.code}", not_equals: ""}, {value: "${item.number}", equals: 1}'
    run = Reading('S').go(2, f', fails_unless: {{all: [{parts}]}}, on_failure: continue')
    assert run.reasons() == ['result_refused']
    assert serials(run) == [('J/1', 'S')]
    assert run.ended


ROUNDS = """
script: test
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2:
    - repeat:
        - {id: read, @a2.RUN, identifies: code}
        - {id: weigh, @a2.RUN, fails_unless: {value: "${results.weigh.value}", at_most: 1}}
      times: 1
  3: [{id: pack, @a3, qty_change: -1}]
"""


def test_6_8_reread_in_another_round_is_no_duplicate() -> None:
    reading = Reading('S', faults='"#2=reads:5"')
    script = parse_script(expanded(ROUNDS), 'test.yaml', reading.cell, TYPES)
    reading.run.submit('J', script, 1)
    run = reading.run.go()
    assert run.reasons() == ['result_refused']
    assert serials(run) == [('J/1', 'S')]
    assert run.ended


def test_6_8_serial_of_ended_job_stays_known() -> None:
    reading = Reading(faults='"#*=reads:1"')
    reading.go()
    reading.run.submit('K', reading.script(), 1)
    (hold,) = reading.run.go().state.holds.values()
    assert hold.message.startswith("the serial 'S-1' is in the history; ")


LOTS = """
script: test
params: {glue: {type: str, default: ""}, n: {type: int, default: 7}}
lots: {glue: "${params.glue}", screws: "${params.n}", box: "${order.id}-${params.glue}"}
sections:
  1: [{id: place, @a1, qty_change: 1, on_failure: continue}]
  3: [{id: pack, @a3, qty_change: -1}]
"""


def lots_of(run: VirtualRun) -> list[Any]:
    return [record.get('lots') for record in run.all('item.placed')]


def test_6_9_each_item_has_the_lots_of_its_order() -> None:
    reading = Reading()
    script = parse_script(expanded(LOTS), 'test.yaml', reading.cell, TYPES)
    reading.run.submit('J', script, 1, glue=' L-1 ', n=8)
    reading.run.submit('K', script, 1, glue='', n=7)
    run = reading.run.go(until=2.0)
    assert run.state.items['J/1'].lots == {'glue': 'L-1', 'screws': '8', 'box': 'J- L-1'}
    run.go()
    assert lots_of(run) == [
        {'glue': 'L-1', 'screws': '8', 'box': 'J- L-1'},
        {'screws': '7', 'box': 'K-'},
    ]


def test_6_9_what_was_never_placed_has_no_lots() -> None:
    reading = Reading()
    script = parse_script(expanded(LOTS), 'test.yaml', reading.cell, TYPES)
    reading.run.submit('J', script, 1)
    run = reading.run
    run.go(until=0.5)
    assert run.state.items['J/1'].lots == {}
