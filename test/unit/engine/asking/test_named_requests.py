"""A request that comes as texts is the same as one of any other door, and all else is refused."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from fakes.request_bench import RequestBench

from bt_orchestrator.model.limits import REQUEST_BYTES

ORDER = {'order': 'A', 'script': 'boxes', 'quantity': 2, 'params': {'speed': 3}, 'priority': 4}


@pytest.fixture
def bench(tmp_path: Path) -> RequestBench:
    return RequestBench(tmp_path)


def test_orders_as_json_are_read_like_order_files(bench: RequestBench) -> None:
    answer = bench.ask_named('queue.add', json.dumps({'orders': [ORDER], 'held': True}))
    assert answer.message == 'A is queued and held'
    assert [order.job for order in answer.orders] == ['A']
    (queued,) = bench.records('job.queued')
    assert (queued.quantity, queued.params, queued.priority) == (2, {'speed': 3}, 4)


def test_an_order_without_an_id_gets_one(bench: RequestBench) -> None:
    answer = bench.ask_named(
        'queue.add', json.dumps({'orders': [{'script': 'boxes', 'quantity': 1}, ORDER]})
    )
    assert answer.accepted
    assert [order.job for order in answer.orders] == ['WO-1', 'A']


def test_orders_by_recipe_are_generated(bench: RequestBench) -> None:
    answer = bench.ask_named('queue.add', '{orders: [{recipe: BOX, order: R, quantity: 3}]}')
    assert answer.accepted, answer.message
    (queued,) = bench.records('job.queued')
    assert (queued.job, queued.recipe) == ('R', 'BOX')


def test_mistakes_of_orders_are_findings(bench: RequestBench) -> None:
    wrong = {**ORDER, 'quantity': 'many', 'colour': 'red'}
    answer = bench.ask_named('queue.add', json.dumps({'orders': [wrong]}))
    assert answer.message == 'refused with 2 findings'
    assert 'colour' in str(answer.orders[0].findings)


def test_yaml_is_read_as_well(bench: RequestBench) -> None:
    bench.ask_named('queue.add', json.dumps({'orders': [ORDER, {**ORDER, 'order': 'B'}]}))
    assert bench.ask_named('job.update', '{job: B, params: {speed: 5}}').accepted
    assert bench.ask_named('job.next', 'job: B').accepted
    assert bench.sim.state.jobs['B'].job.params == {'speed': 5}


def test_a_change_of_nothing_is_refused(bench: RequestBench) -> None:
    bench.ask_named('queue.add', json.dumps({'orders': [ORDER], 'held': True}))
    answer = bench.ask_named('job.update', '{job: A}')
    assert not answer.accepted
    assert answer.message.startswith('say what to change: quantity, params, script, ')


@pytest.mark.parametrize(
    ('name', 'arguments', 'message'),
    [
        ('cell.fly', '', "there is no request 'cell.fly'; one of cell.reset, cell.start"),
        ('job.move', '{"job": "A"}', 'job.move needs position: place in the queue, from 1'),
        ('job.move', '{"job": 7, "position": 1}', 'job of job.move is text (id of the job); fo'),
        ('job.move', '{"job": "A", "position": -1}', 'is a whole number from 0 to 4294967295'),
        ('job.move', '{"job": "A", "position": 1e400}', 'position of job.move is whole number'),
        ('job.update', '{"job": "A", "priority": 40000}', 'from -32768 to 32767'),
        ('job.hold', '["A"]', 'expected the arguments as a mapping in JSON or YAML'),
        ('job.hold', '{job: A, job: B}', 'expected the arguments as a mapping in JSON or YAML'),
        ('job.hold', '[' * 100_000, 'arguments of more than 64000 characters must be JSON'),
        ('job.hold', '{"job": "\\ud800"}', 'the arguments are not a valid text: surrogates not'),
        ('job.hold', '{"by": "me", "name": "x"}', 'job.hold takes job; found by'),
        ('job.hold', ' ' * (REQUEST_BYTES + 1), 'expected at most 1000000'),
        (
            'queue.add',
            '{"orders": ["boxes"]}',
            'each work order is a mapping, as an order file; f',
        ),
    ],
)
def test_malformed_request_is_refused_on_record(
    bench: RequestBench, name: str, arguments: str, message: str
) -> None:
    answer = bench.ask_named(name, arguments)
    assert not answer.accepted
    assert message in answer.message
    (refused,) = bench.records('operator.refused')
    assert (refused.who, refused.message[:60]) == ('Ann', answer.message[:60])
    assert refused.command in name
