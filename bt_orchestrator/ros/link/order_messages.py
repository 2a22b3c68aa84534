"""Work orders as messages; the node reads what they say."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from bt_orchestrator_interfaces.msg import WorkOrder as WorkOrderMessage
from bt_orchestrator_interfaces.srv import QueueUpdate

from bt_orchestrator.model.jobs.order import WorkOrder
from bt_orchestrator.ros.stamps import to_moment, to_time
from bt_orchestrator.ros.types.choice_messages import choice_fields, key_values
from bt_orchestrator.script.orders.asked import asked_of, change_of


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


def change_message(given: Mapping[str, Any]) -> Any:
    """Return the request that changes a job (srv/QueueUpdate).

    :raises CommandRefused: a time is none
    """
    wish = change_of(given)
    terms = wish.terms
    return QueueUpdate.Request(
        job=given['job'],
        script=wish.script,
        quantity=wish.quantity,
        params=key_values(wish.params),
        priority=[] if terms.priority is None else [terms.priority],
        start=[] if terms.start is None else [to_time(terms.start)],
        due=[] if terms.due is None else [to_time(terms.due)],
        details=terms.details,
        **choice_fields(wish.recipe),
    )
