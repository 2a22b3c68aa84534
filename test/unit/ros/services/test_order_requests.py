"""How much a request may have, and how much its answer tells."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from bt_orchestrator.errors import Finding, Refused
from bt_orchestrator.model.limits import FINDINGS, ORDERS, REQUEST_BYTES
from bt_orchestrator.ros.services.order_process import NotRead
from bt_orchestrator.ros.services.order_requests import (
    Told,
    asked_change,
    asked_orders,
    written_order,
)
from bt_orchestrator.script.orders.desk import AskedOrder
from bt_orchestrator.script.orders.terms import AskedTerms


def order(script: str = 'small', **params: str) -> SimpleNamespace:
    pairs = [SimpleNamespace(key=key, value=value) for key, value in params.items()]
    zero = SimpleNamespace(sec=0, nanosec=0)
    terms = SimpleNamespace(priority=0, start=zero, due=zero, details='')
    return SimpleNamespace(order='', script=script, quantity=2, params=pairs, **vars(terms))


def refused(mistakes: int) -> Refused:
    return Refused([Finding('a.yaml', line, 1, 'wrong') for line in range(1, mistakes + 1)])


def test_orders_are_taken_as_texts() -> None:
    terms = AskedTerms(0, 0.0, 0.0)
    asked = AskedOrder('small', '', 2, {'lot': 'A7'}, terms)
    assert asked_orders([order(lot='A7')]).orders == (asked,)


def test_a_change_says_what_it_says_and_leaves_the_rest() -> None:
    nothing = {'priority': [], 'start': [], 'due': [], 'details': ''}
    change = SimpleNamespace(script='', quantity=0, params=[], **nothing)
    assert asked_change(change) == AskedOrder('')
    change.priority, change.start = [7], [SimpleNamespace(sec=0, nanosec=0)]
    change.due = [SimpleNamespace(sec=1779084000, nanosec=500_000_000)]
    assert asked_change(change).terms == AskedTerms(7, 0.0, 1779084000.5)


def test_a_request_has_so_many_orders() -> None:
    assert len(asked_orders([order()] * ORDERS).orders) == ORDERS
    with pytest.raises(NotRead, match=f'nothing was queued; give {ORDERS} or fewer at a time'):
        asked_orders([order()] * (ORDERS + 1))


@pytest.mark.parametrize('letter', ['x', 'ü'])
def test_a_request_has_so_much_text(letter: str) -> None:
    fits = letter * (REQUEST_BYTES // 2 // len(letter.encode()) - 10)
    assert len(asked_orders([order(lot=fits), order(lot=fits)]).orders) == 2
    with pytest.raises(NotRead, match=f'and a request may have {REQUEST_BYTES}; nothing was'):
        asked_orders([order(lot=fits), order(lot=fits), order(lot='x' * 100)])
    assert written_order(fits).text == fits
    with pytest.raises(NotRead, match='nothing was queued; is this a work order'):
        written_order(letter * REQUEST_BYTES + 'x')


def test_an_answer_tells_so_many_mistakes_of_all_orders_together() -> None:
    told = Told()
    first, second, third = (told.of(refused(count)) for count in (FINDINGS - 1, 3, 1))
    assert (len(first), first[0]) == (FINDINGS - 1, 'a.yaml:1:1: wrong')
    rest = 'more; bt-orchestrator check --json, where the files are, lists all'
    assert second == ['a.yaml:1:1: wrong', f'and 2 {rest}']
    assert third == [], 'it is said once; the message of the answer counts all'
