"""Messages with work orders as what is to be read."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, overload

from bt_orchestrator.base.errors import NotRead
from bt_orchestrator.engine.asking.orders import size_of
from bt_orchestrator.model.limits import REQUEST_BYTES
from bt_orchestrator.ros.types.order_messages import asked_order
from bt_orchestrator.script.orders.desk import AskedOrder, WrittenOrder


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
