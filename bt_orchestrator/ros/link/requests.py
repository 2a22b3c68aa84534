"""Requests as calls of the node's services, and their responses as answers."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from bt_orchestrator_interfaces import srv

from bt_orchestrator.errors import CommandRefused
from bt_orchestrator.model.by import By
from bt_orchestrator.model.commands import Answer, OrderAnswer
from bt_orchestrator.model.requests import About, Asked
from bt_orchestrator.model.wish import STOP_AFTER
from bt_orchestrator.ros.types.messages import check


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
        call = _MAKERS[asked.request.about](asked.request.word, asked.arguments)
        _sign(call.request, asked.by)
        check(call.request)
    except (OverflowError, TypeError, ValueError) as error:
        raise CommandRefused(f'{asked.request.name} cannot be sent: {error}') from error
    return call


def _sign(request: Any, by: By) -> None:
    request.who, request.origin, request.reason = by.who, by.origin, by.reason
    if by.known.is_door:
        request.known, request.role = by.known.value, by.role.value


def answer_of(response: Any) -> Answer:
    """Return what a service has answered."""
    each = getattr(response, 'answers', ())
    orders = [OrderAnswer(one.job, one.message, tuple(one.findings)) for one in each]
    findings = tuple(getattr(response, 'findings', ()))
    if findings:
        orders = [OrderAnswer(message=response.message, findings=findings)]
    return Answer(response.accepted, response.message, orders=tuple(orders))


def _to_cell(word: str, given: Mapping[str, Any]) -> Call:
    if word.startswith(STOP_AFTER):
        after = word.removeprefix(STOP_AFTER)
        request = srv.QueueStopAfter.Request(after=after)
        return Call(srv.QueueStopAfter, 'queue/stop_after', request)
    return Call(srv.Command, 'command', srv.Command.Request(command=word, **given))


def _to_queue(_: str, given: Mapping[str, Any]) -> Call:
    from bt_orchestrator.ros.link.order_messages import order_message

    request = srv.QueueAdd.Request(
        orders=[order_message(order) for order in given['orders']],
        position=given.get('position', 0),
        held=given.get('held', False),
    )
    return Call(srv.QueueAdd, 'queue/add', request)


def _to_job(word: str, given: Mapping[str, Any]) -> Call:
    if word == 'move':
        return Call(srv.QueueMove, 'queue/move', srv.QueueMove.Request(**given))
    if word == 'update':
        from bt_orchestrator.ros.link.order_messages import change_message

        return Call(srv.QueueUpdate, 'queue/update', change_message(given))
    request = srv.QueueCommand.Request(command=word, **given)
    return Call(srv.QueueCommand, 'queue/command', request)


def _to_item(_: str, given: Mapping[str, Any]) -> Call:
    return Call(srv.RemoveItem, 'remove_item', srv.RemoveItem.Request(**given))


def _to_hold(word: str, given: Mapping[str, Any]) -> Call:
    results = json.dumps(given['results'], ensure_ascii=False) if given.get('results') else ''
    request = srv.AnswerHold.Request(hold=given['hold'], answer=word, results=results)
    return Call(srv.AnswerHold, 'answer_hold', request)


def _to_component(word: str, given: Mapping[str, Any]) -> Call:
    return Call(srv.Command, 'command', srv.Command.Request(command=word, **given))


def _to_script(word: str, given: Mapping[str, Any]) -> Call:
    return Call(srv.Command, 'command', srv.Command.Request(command=word, **given))


_MAKERS: Mapping[About, Callable[[str, Mapping[str, Any]], Call]] = {
    About.CELL: _to_cell,
    About.QUEUE: _to_queue,
    About.JOB: _to_job,
    About.ITEM: _to_item,
    About.HOLD: _to_hold,
    About.COMPONENT: _to_component,
    About.SCRIPT: _to_script,
}
