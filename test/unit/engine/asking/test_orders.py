"""How much a request with orders may have, and how much its answer tells."""

from __future__ import annotations

import pytest

from bt_orchestrator.base.errors import Finding, NotRead, Refused
from bt_orchestrator.engine.asking.orders import Told, wanted_orders
from bt_orchestrator.model.limits import FINDINGS, ORDERS, REQUEST_BYTES
from bt_orchestrator.script.orders.desk import AskedOrder


def order(**params: str) -> AskedOrder:
    return AskedOrder('small', '', 2, params)


def refused(mistakes: int) -> Refused:
    return Refused([Finding('a.yaml', line, 1, 'wrong') for line in range(1, mistakes + 1)])


def test_a_request_has_so_many_orders() -> None:
    assert len(wanted_orders([order()] * ORDERS).orders) == ORDERS
    with pytest.raises(NotRead, match=f'nothing was queued; give {ORDERS} or fewer at a time'):
        wanted_orders([order()] * (ORDERS + 1))
    with pytest.raises(NotRead, match='name at least one order'):
        wanted_orders([])


@pytest.mark.parametrize('letter', ['x', 'ü'])
def test_a_request_has_so_much_text(letter: str) -> None:
    fits = letter * (REQUEST_BYTES // 2 // len(letter.encode()) - 10)
    assert len(wanted_orders([order(lot=fits), order(lot=fits)]).orders) == 2
    with pytest.raises(NotRead, match=f'and a request may have {REQUEST_BYTES}; nothing was'):
        wanted_orders([order(lot=fits), order(lot=fits), order(lot='x' * 100)])


def test_answer_limits_mistakes_of_all_orders() -> None:
    report = Told()
    first, second, third = (report.of(refused(count)) for count in (FINDINGS - 1, 3, 1))
    assert (len(first), first[0]) == (FINDINGS - 1, 'a.yaml:1:1: wrong')
    rest = 'more; bt-orchestrator check --json, where the files are, lists all'
    assert second == ('a.yaml:1:1: wrong', f'and 2 {rest}')
    assert third == (), 'it is said once; the message of the answer counts all'
