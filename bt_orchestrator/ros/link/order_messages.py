"""Work orders as messages; the node reads what they say."""

from __future__ import annotations

from typing import Any

from bt_orchestrator_interfaces.msg import WorkOrder as WorkOrderMessage

from bt_orchestrator.model.jobs.order import WorkOrder
from bt_orchestrator.ros.stamps import to_moment
from bt_orchestrator.ros.types.choice_messages import choice_fields, key_values
from bt_orchestrator.script.orders.asked import asked_of


def order_message(order: WorkOrder) -> Any:
    """Return a work order."""
    asked = asked_of(order)
    return WorkOrderMessage(
        order=asked.order,
        script=asked.script,
        quantity=asked.quantity,
        params=key_values(asked.params),
        priority=order.terms.priority,
        start=to_moment(order.terms.start),
        due=to_moment(order.terms.due),
        details=asked.terms.details,
        **choice_fields(order.recipe),
    )
