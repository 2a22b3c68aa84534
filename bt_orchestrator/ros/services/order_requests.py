"""Requests with work orders as what is to be read, and what is said of them in answers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from bt_orchestrator.deadlines import NS_PER_S
from bt_orchestrator.errors import Refused
from bt_orchestrator.model.by import By
from bt_orchestrator.model.commands import RefusedRequest
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.limits import FINDINGS, ORDERS, REQUEST_BYTES
from bt_orchestrator.ros.services.order_process import NotRead
from bt_orchestrator.runtime.command_record import ADD
from bt_orchestrator.runtime.orders import FITS
from bt_orchestrator.script.orders.desk import AskedOrder, Orders, WrittenOrder
from bt_orchestrator.script.orders.terms import AskedTerms

ALL = 'bt-orchestrator check --json, where the files are, lists all'


def asked_orders(orders: Sequence[Any]) -> Orders:
    """Return the orders of a request (bt_orchestrator_interfaces/msg/WorkOrder).

    :raises NotRead: they are too many, or too large
    """
    if len(orders) > ORDERS:
        raise NotRead(
            f'{len(orders)} orders are too many for one request, which is carried out as a whole; '
            f'nothing was queued; give {ORDERS} or fewer at a time'
        )
    return _not_too_large(_asked(order, order.order, _terms(order)) for order in orders)


def asked_change(request: Any) -> AskedOrder:
    """Return what a queued job is to be (bt_orchestrator_interfaces/srv/QueueUpdate).

    :raises NotRead: it is too large
    """
    terms = AskedTerms(
        next(iter(request.priority), None),
        next(map(_seconds, request.start), None),
        next(map(_seconds, request.due), None),
        request.details,
    )
    (asked,) = _not_too_large([_asked(request, '', terms)]).orders
    return asked


def _seconds(time: Any) -> float:
    return float(time.sec + time.nanosec / NS_PER_S)


def _not_too_large(orders: Iterable[AskedOrder]) -> Orders:
    asked = tuple(orders)
    size = sum(map(_size, asked))
    if size > REQUEST_BYTES:
        raise NotRead(
            f'the orders of this request have {size} bytes of text, and a request may have '
            f'{REQUEST_BYTES}; nothing was queued; give fewer at a time, or shorter ones'
        )
    return Orders(asked)


def _asked(order: Any, name: str, terms: AskedTerms) -> AskedOrder:
    params = {param.key: param.value for param in order.params}
    return AskedOrder(order.script, name, order.quantity, params, terms)


def _terms(order: Any) -> AskedTerms:
    start, due = _seconds(order.start), _seconds(order.due)
    return AskedTerms(order.priority, start, due, order.details)


def written_order(text: str) -> WrittenOrder:
    """Return an order that came as the text of a file.

    :raises NotRead: it is too large
    """
    if _bytes(text) > REQUEST_BYTES:
        raise NotRead(
            f'the text has {_bytes(text)} bytes, and a request may have {REQUEST_BYTES}; nothing '
            'was queued; is this a work order?'
        )
    return WrittenOrder(text)


def name_of(order: Any) -> str:
    """Return the words by which a client knows its order (msg/WorkOrder)."""
    return str(order.order or order.script or 'the order')


def refused_orders(orders: Sequence[Any], read: Sequence[Job | Refused], by: By) -> RefusedRequest:
    """Return what is put on record of orders that were read, some of them with mistakes."""
    each = [
        f'{one.id} {FITS}' if isinstance(one, Job) else f'{name_of(order)} is {one.in_short}'
        for order, one in zip(orders, read, strict=True)
    ]
    ids = tuple(
        one.id if isinstance(one, Job) else order.order
        for order, one in zip(orders, read, strict=True)
    )
    return RefusedRequest(ADD, by, '; '.join(each), ids, tuple(each))


class Told:
    """Findings for one answer: not more than it may have."""

    def __init__(self) -> None:
        self._left = FINDINGS
        self._said_that_more = False

    def of(self, refused: Refused) -> list[str]:
        """Return the mistakes of one order."""
        told = refused.findings[: self._left]
        self._left -= len(told)
        more = len(refused.findings) - len(told)
        rest = [f'and {more} more; {ALL}'] if more and not self._said_that_more else []
        self._said_that_more |= more > 0
        return [*map(str, told), *rest]


def _size(order: AskedOrder) -> int:
    params: Mapping[str, str] = order.params
    texts = (order.script, order.order, order.terms.details, *params, *params.values())
    return sum(map(_bytes, texts))


def _bytes(text: str) -> int:
    return len(text) if text.isascii() else len(text.encode(errors='replace'))


def total(read: Iterable[Job | Refused]) -> int:
    """Count the mistakes in all orders."""
    return sum(len(one.findings) for one in read if isinstance(one, Refused))
