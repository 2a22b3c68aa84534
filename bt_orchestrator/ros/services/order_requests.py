"""Messages with work orders as what is to be read."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, overload

from bt_orchestrator.asking.orders import size_of
from bt_orchestrator.deadlines import NS_PER_S
from bt_orchestrator.errors import NotRead
from bt_orchestrator.model.limits import REQUEST_BYTES
from bt_orchestrator.ros.types.choice_messages import choice_from
from bt_orchestrator.script.orders.desk import AskedOrder, WrittenOrder
from bt_orchestrator.script.orders.terms import AskedTerms


class AskedOrders(Sequence[AskedOrder]):
    """Orders of a request, each made when it is asked for: too many are refused unread."""

    def __init__(self, messages: Sequence[Any]) -> None:
        """Show them.

        :param messages: bt_orchestrator_interfaces/msg/WorkOrder
        """
        self._messages = messages

    def __len__(self) -> int:
        return len(self._messages)

    @overload
    def __getitem__(self, at: int) -> AskedOrder: ...
    @overload
    def __getitem__(self, at: slice) -> Sequence[AskedOrder]: ...
    def __getitem__(self, at: int | slice) -> AskedOrder | Sequence[AskedOrder]:
        if isinstance(at, slice):
            return AskedOrders(self._messages[at])
        return asked_order(self._messages[at])


def asked_order(order: Any) -> AskedOrder:
    """Return an order (bt_orchestrator_interfaces/msg/WorkOrder)."""
    start, due = _seconds(order.start), _seconds(order.due)
    return _asked(order, order.order, AskedTerms(order.priority, start, due, order.details))


def asked_change(request: Any) -> AskedOrder:
    """Return what a queued job is to be (bt_orchestrator_interfaces/srv/QueueUpdate)."""
    terms = AskedTerms(
        next(iter(request.priority), None),
        next(map(_seconds, request.start), None),
        next(map(_seconds, request.due), None),
        request.details,
    )
    return _asked(request, '', terms)


def _asked(order: Any, name: str, terms: AskedTerms) -> AskedOrder:
    params = {param.key: param.value for param in order.params}
    return AskedOrder(order.script, name, order.quantity, params, terms, choice_from(order))


def _seconds(time: Any) -> float:
    return float(time.sec + time.nanosec / NS_PER_S)


def written_order(text: str) -> WrittenOrder:
    """Return an order that came as the text of a file.

    :raises NotRead: it is too large
    """
    if size_of(text) > REQUEST_BYTES:
        raise NotRead(
            f'the text has {size_of(text)} bytes, and a request may have {REQUEST_BYTES}; nothing '
            'was queued; is this a work order?'
        )
    return WrittenOrder(text)
