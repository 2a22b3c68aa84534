"""Orders of a request become what is to be read, and not before it is wanted."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from bt_orchestrator_interfaces.msg import WorkOrder
from bt_orchestrator_interfaces.srv import QueueUpdate

from bt_orchestrator.base.errors import NotRead
from bt_orchestrator.engine.asking.orders import wanted_orders
from bt_orchestrator.model.jobs.order import RecipeChoice
from bt_orchestrator.model.jobs.order import WorkOrder as Order
from bt_orchestrator.ros.services.services import AskedOrders
from bt_orchestrator.ros.types.order_messages import asked_change, asked_order, order_message
from bt_orchestrator.ros.types.status_messages import CHOICE as AS_FIELDS
from bt_orchestrator.script.orders.asked import asked_of, change_of


class Unread(SimpleNamespace):
    """A message whose fields nobody may ask for."""

    def __getattr__(self, name: str) -> Any:
        raise AssertionError(f'{name} was read')


def test_too_many_orders_are_refused_by_count() -> None:
    with pytest.raises(NotRead, match='20000 orders are too many'):
        wanted_orders(AskedOrders([Unread()] * 20_000))


def test_orders_are_read_singly_and_in_part() -> None:
    orders = AskedOrders([WorkOrder(order=f'WO-{n}', script='small') for n in range(3)])
    assert [order.order for order in orders] == ['WO-0', 'WO-1', 'WO-2']
    assert [order.order for order in orders[1:]] == ['WO-1', 'WO-2']
    assert [order.order for order in wanted_orders(orders).orders] == ['WO-0', 'WO-1', 'WO-2']


CHOICE = RecipeChoice(('WM-100', 'WM-101'), 2, {'insert': 'component_3a'})


@pytest.mark.parametrize('choice', [None, CHOICE, RecipeChoice(('WM-100',))])
def test_order_by_recipe_survives_message(choice: RecipeChoice | None) -> None:
    order = Order('' if choice else 'small', 'WO-1', 3, recipe=choice)
    assert asked_order(order_message(asked_of(order))) == asked_of(order)
    assert asked_order(order_message(asked_of(order))).recipe == choice


def test_recipe_change_survives_message() -> None:
    given = {'job': 'J', 'recipe': ['WM-100', 'WM-101'], 'version': 2, 'bind': CHOICE.bind}
    message = QueueUpdate.Request(job='J', **AS_FIELDS.write(CHOICE))
    assert asked_change(message) == change_of(given)
    assert change_of(given).recipe == CHOICE
    assert asked_change(QueueUpdate.Request(job='J')).recipe is None
