"""Orders as JSON objects: what is wrong stands at the key that it is about."""

from __future__ import annotations

import pytest
from fakes.action_types import FakeActionTypes
from fakes.script_texts import LINE, cell, script

from bt_orchestrator.base.errors import Refused
from bt_orchestrator.model.jobs.order import Job, WorkOrder
from bt_orchestrator.script.orders.parameter_uses import action_types
from bt_orchestrator.script.orders.plain_order import bound, draft_of, order_from

SCRIPT = script(
    LINE + 'params: {lot: {type: str}, n: {type: int, default: 3}, '
    'x: {type: float, default: 1}, b: {type: bool, default: false}}\n'
)
TYPES = action_types(cell(), FakeActionTypes())
ORDER = {'script': 'test', 'order': 'WO-7', 'quantity': 2, 'params': {'lot': '5', 'n': '5'}}


def fields(plain: dict[str, object]) -> dict[str, str]:
    findings = bound(plain, SCRIPT, TYPES)
    assert not isinstance(findings, Job), findings
    return {finding.field: finding.what for finding in findings}


def test_texts_become_what_the_script_declares() -> None:
    job = bound(ORDER, SCRIPT, TYPES)
    assert isinstance(job, Job)
    assert (job.id, job.quantity) == ('WO-7', 2)
    assert job.params == {'lot': '5', 'n': 5, 'x': 1.0, 'b': False}


def test_plain_order_is_read_like_its_file() -> None:
    plain = {**ORDER, 'due': '1970-01-01T00:01:00Z', 'details': {'lines': ['a\nb', '“€😀']}}
    order = order_from(plain)
    assert order.terms.due == 60.0
    assert order.terms.details == {'lines': ['a\nb', '“€😀']}
    assert order.params == {'lot': '5', 'n': '5'}
    assert order_from({'script': 'test'}) == WorkOrder('test')


@pytest.mark.parametrize(
    ('change', 'field', 'words'),
    [
        ({'params': {'lot': 'A', 'n': 'many'}}, 'params.n', 'must be a whole number'),
        ({'params': {'lot': 'A', 'm': '1'}}, 'params.m', 'has no parameter'),
        ({'params': {'n': '1'}}, 'params.lot', 'is missing'),
        ({'params': {}}, 'params.lot', 'is missing'),
        ({'quantity': 0}, 'quantity', 'at least 1'),
        ({'quantity': 'two'}, 'quantity', 'whole number'),
        ({'priority': 99999}, 'priority', 'at most 32767'),
        ({'order': 'a/b'}, 'order', '/'),
        ({'due': '2026-05-18T12:00'}, 'due', 'time zone'),
        ({'start': '2026-05-18T12:00Z', 'due': '2026-05-18T11:00Z'}, 'due', 'before'),
        ({'details': {'a': {'b': 10**30}}}, 'details', '64 bits'),
        ({'details': 'text'}, 'details', 'mapping'),
        ({'colour': 'red'}, 'colour', 'colour'),
    ],
)
def test_a_mistake_stands_at_its_field(change: dict[str, object], field: str, words: str) -> None:
    findings = fields({**ORDER, **change})
    assert list(findings) == [field]
    assert words in findings[field]


def test_a_missing_quantity_stands_at_its_field() -> None:
    plain = {key: value for key, value in ORDER.items() if key != 'quantity'}
    assert list(fields(plain)) == ['quantity']


def test_every_mistake_is_told_at_once() -> None:
    plain = {**ORDER, 'quantity': 0, 'priority': 'high', 'params': {'n': 'x', 'b': 'perhaps'}}
    assert set(fields(plain)) == {'quantity', 'priority', 'params.lot', 'params.n', 'params.b'}


def test_mistakes_without_a_script() -> None:
    draft, (wrong,) = draft_of({**ORDER, 'priority': 'high'})
    assert draft is not None
    assert (draft.script, wrong.field) == (ORDER['script'], 'priority')
    draft, (wrong,) = draft_of({'order': 'WO-7'})
    assert (draft, wrong.what) == (None, 'a work order needs the key `script` or `recipe`')
    assert draft_of(ORDER) == (order_from(ORDER), ())
    with pytest.raises(Refused):
        order_from({'order': 'WO-7'})
