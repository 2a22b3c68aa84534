"""Messages with work orders are taken as texts, and not more of them than a request may have."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from bt_orchestrator.errors import NotRead
from bt_orchestrator.model.limits import REQUEST_BYTES
from bt_orchestrator.ros.services.order_requests import asked_change, asked_order, written_order
from bt_orchestrator.script.orders.desk import AskedOrder
from bt_orchestrator.script.orders.terms import AskedTerms


def test_orders_are_taken_as_texts() -> None:
    params = [SimpleNamespace(key='lot', value='A7')]
    zero = SimpleNamespace(sec=0, nanosec=0)
    terms = {'priority': 0, 'start': zero, 'due': zero, 'details': ''}
    order = SimpleNamespace(order='', script='small', quantity=2, params=params, **terms)
    asked = AskedOrder('small', '', 2, {'lot': 'A7'}, AskedTerms(0, 0.0, 0.0))
    assert asked_order(order) == asked


def test_a_change_says_what_it_says_and_leaves_the_rest() -> None:
    nothing = {'priority': [], 'start': [], 'due': [], 'details': ''}
    change = SimpleNamespace(script='', quantity=0, params=[], **nothing)
    assert asked_change(change) == AskedOrder('')
    change.priority, change.start = [7], [SimpleNamespace(sec=0, nanosec=0)]
    change.due = [SimpleNamespace(sec=1779084000, nanosec=500_000_000)]
    assert asked_change(change).terms == AskedTerms(7, 0.0, 1779084000.5)


@pytest.mark.parametrize('letter', ['x', 'ü'])
def test_a_written_order_has_so_much_text(letter: str) -> None:
    fits = letter * (REQUEST_BYTES // len(letter.encode()))
    assert written_order(fits).text == fits
    with pytest.raises(NotRead, match='nothing was queued; is this a work order'):
        written_order(letter * REQUEST_BYTES + 'x')
