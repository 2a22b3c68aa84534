"""Services with requests: any by its name, and a door of its own for those of earlier versions."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from bt_orchestrator_interfaces import srv
from rclpy.node import Node

from bt_orchestrator.engine.asking.handler import RequestHandler
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.requests import of_name
from bt_orchestrator.model.state import CellState
from bt_orchestrator.ros.services.order_requests import AskedOrders
from bt_orchestrator.ros.services.senders import Senders
from bt_orchestrator.ros.services.serving import serve
from bt_orchestrator.ros.types.order_messages import asked_change, asked_order
from bt_orchestrator.ros.types.status_messages import order_answer_message

_Read = Callable[[Any], tuple[str, Any]]
"""Returns the name of the request in a message, and its arguments."""


def _fields(name: str, message: Any) -> tuple[str, dict[str, Any]]:
    """Return a request with those fields of a message that it takes and that say something."""
    request = of_name(name)
    told = (
        {one.name: getattr(message, one.name, None) for one in request.parameters}
        if request
        else {}
    )
    return name, {name: value for name, value in told.items() if value}


def _command(message: Any) -> tuple[str, dict[str, Any]]:
    subject = 'component' if message.component else 'script' if message.script else 'cell'
    return _fields(f'{subject}.{message.command}', message)


def _answer(message: Any) -> tuple[str, dict[str, Any]]:
    given = {'hold': message.hold, 'results': message.results or None}
    return f'hold.{message.answer}', given


DOORS: tuple[tuple[Any, str, _Read], ...] = (
    (srv.MakeRequest, 'request', lambda message: (message.name, message.arguments)),
    (srv.AnswerHold, 'answer_hold', _answer),
    (srv.RemoveItem, 'remove_item', partial(_fields, 'item.remove_item')),
    (srv.Command, 'command', _command),
    (srv.QueueMove, 'queue/move', partial(_fields, 'job.move')),
    (srv.QueueCommand, 'queue/command', lambda it: _fields(f'job.{it.command}', it)),
    (
        srv.QueueStopAfter,
        'queue/stop_after',
        lambda it: _fields(f'cell.stop_after_{it.after}', it),
    ),
)
"""Services with one request, as the table of requests names it."""


class Services:
    """Requests become commands in the one inbox of the cell; nothing is decided here."""

    def __init__(
        self, node: Node, handler: RequestHandler, senders: Senders, state: CellState
    ) -> None:
        self._handler = handler
        self._senders = senders
        self._state = state
        for kind, name, read in DOORS:
            serve(node, kind, name, partial(self._carry_out, read))
        serve(node, srv.SubmitOrder, 'submit_order', self._submit)
        serve(node, srv.QueueAdd, 'queue/add', self._add)
        serve(node, srv.QueueUpdate, 'queue/update', self._update)

    async def _carry_out(self, read: _Read, request: Any, response: Any) -> None:
        by = self._senders.by(request)
        self._tell(response, await self._handler.carry_out_named(*read(request), by))

    async def _submit(self, request: Any, response: Any) -> None:
        by = self._senders.by(request)
        self._tell(response, await self._handler.add([asked_order(request)], by))

    async def _add(self, request: Any, response: Any) -> None:
        orders, by = AskedOrders(request.orders), self._senders.by(request)
        position = request.position or None
        answer = await self._handler.add(orders, by, position, held=request.held)
        self._tell(response, answer)

    async def _update(self, request: Any, response: Any) -> None:
        wish, by = asked_change(request), self._senders.by(request)
        self._tell(response, await self._handler.update(request.job, wish, by))

    def _tell(self, response: Any, answer: Answer) -> None:
        """Put an answer into a response, as far as that has fields for it."""
        told: dict[str, object] = {
            'accepted': answer.accepted,
            'message': answer.message,
            'answers': list(map(order_answer_message, answer.orders)),
            'state': self._state.packml.value,
        }
        for of_order in answer.orders:
            told |= {'job': of_order.job, 'findings': of_order.findings}
        for name in told.keys() & set(response.get_fields_and_field_types()):
            setattr(response, name, told[name])
