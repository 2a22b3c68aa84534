"""Orders of a request become what is to be read, and not before it is wanted."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from bt_orchestrator_interfaces.msg import WorkOrder

from bt_orchestrator.asking.orders import wanted_orders
from bt_orchestrator.errors import NotRead
from bt_orchestrator.ros.services.order_requests import AskedOrders


class Unread(SimpleNamespace):
    """A message whose fields nobody may ask for."""

    def __getattr__(self, name: str) -> Any:
        raise AssertionError(f'{name} was read')


def test_too_many_orders_are_refused_by_their_number_alone() -> None:
    with pytest.raises(NotRead, match='20000 orders are too many'):
        wanted_orders(AskedOrders([Unread()] * 20_000))


def test_orders_are_read_one_by_one_and_in_part() -> None:
    orders = AskedOrders([WorkOrder(order=f'WO-{n}', script='small') for n in range(3)])
    assert [one.order for one in orders] == ['WO-0', 'WO-1', 'WO-2']
    assert [one.order for one in orders[1:]] == ['WO-1', 'WO-2']
    assert [one.order for one in wanted_orders(orders).orders] == ['WO-0', 'WO-1', 'WO-2']
