"""Requests as calls of the node's services, and their responses as answers."""

from __future__ import annotations

from typing import Any, NamedTuple

from bt_orchestrator_interfaces import srv

from bt_orchestrator.base.errors import CommandRefused
from bt_orchestrator.model.by import By
from bt_orchestrator.model.codec import json_of
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.jobs.order import WorkOrder
from bt_orchestrator.model.requests import Asked
from bt_orchestrator.ros.types.messages import check
from bt_orchestrator.ros.types.status_messages import order_answer
from bt_orchestrator.script.users.keys import Place, SigningKey, sealed


class Call(NamedTuple):
    """A call of one service."""

    kind: Any
    service: str
    request: Any


def call_of(asked: Asked) -> Call:
    """Return the call that carries a request.

    :raises CommandRefused: a value that no message can carry; says which
    """
    try:
        call = _add(asked) if _has_orders(asked) else _any(asked)
        _say_who(call.request, asked.sender)
        check(call.request)
    except (OverflowError, TypeError, ValueError) as error:
        raise CommandRefused(f'{asked.request.name} cannot be sent: {error}') from error
    return call


def signed_call(asked: Asked, key: SigningKey, place: Place) -> srv.SignedRequest.Request:
    """Return the request that carries another one with its signature.

    :param place: as the node has told it a moment ago
    :raises CommandRefused: a value that no message can carry; says which
    """
    try:
        carried = _any(asked).request
        number = key.next_number()
        text = sealed(carried.name, carried.arguments, asked.sender, place, number).text
        request = srv.SignedRequest.Request(request=text, key=key.public)
        request.signature = list(key.sign(text))
        check(request)
    except (OverflowError, TypeError, ValueError) as error:
        raise CommandRefused(f'{asked.request.name} cannot be sent: {error}') from error
    return request


def _has_orders(asked: Asked) -> bool:
    """Tell whether its orders are carried by messages, which have no field for a first piece."""
    orders = asked.arguments.get('orders', ())
    return asked.request.takes_orders and all(
        isinstance(order, WorkOrder) and not order.terms.first_piece for order in orders
    )


def _say_who(request: Any, by: By) -> None:
    request.who, request.origin, request.reason = by.who, by.origin, by.reason
    if by.known.is_door:
        request.known, request.role = by.known.value, by.role.value


def answer_of(response: Any) -> Answer:
    """Return what a service has answered."""
    orders = tuple(map(order_answer, response.answers))
    return Answer(response.accepted, response.message, orders=orders)


def _any(asked: Asked) -> Call:
    from bt_orchestrator.script.orders.asked import mapping_of

    arguments = dict(asked.arguments)
    if asked.request.takes_orders:
        orders: Any = arguments['orders']
        arguments['orders'] = [
            mapping_of(order) if isinstance(order, WorkOrder) else order for order in orders
        ]
    request = srv.MakeRequest.Request(name=asked.request.name, arguments=json_of(arguments))
    return Call(srv.MakeRequest, 'request', request)


def _add(asked: Asked) -> Call:
    """Return a call with the orders as messages: their texts are read in their own process."""
    from bt_orchestrator.ros.types.order_messages import order_message
    from bt_orchestrator.script.orders.asked import asked_of

    orders: Any = asked.arguments['orders']
    given: Any = {key: value for key, value in asked.arguments.items() if key != 'orders'}
    messages = [order_message(asked_of(order)) for order in orders]
    request = srv.QueueAdd.Request(orders=messages, **given)
    return Call(srv.QueueAdd, 'queue/add', request)
