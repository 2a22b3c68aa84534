"""Every request of the table has its call of a service; what the node says is read, or refused."""

from __future__ import annotations

from typing import Any

import pytest
from bt_orchestrator_interfaces.msg import Event

from bt_orchestrator.base.errors import CommandRefused, NodeUnreachable
from bt_orchestrator.model.by import By, Known, Role
from bt_orchestrator.model.jobs.order import WorkOrder
from bt_orchestrator.model.requests import TABLE, BadArguments, Kind, Parameter, ask
from bt_orchestrator.ros.link.requests import Call, call_of
from bt_orchestrator.ros.link.ros_link import event_of
from bt_orchestrator.script.given_values import arguments_of

ANN = By('Ann', 'test', 'because')

OF_KIND: dict[Kind, object] = {
    Kind.TEXT: 'none',
    Kind.WHOLE: 7,
    Kind.YES_NO: True,
    Kind.TEXTS: ['1=empty'],
    Kind.VALUES: {'a': 1.5},
    Kind.ORDERS: [WorkOrder('boxes', 'WO-1', 2, {'lot': 'A7'})],
}


def value(parameter: Parameter) -> object:
    if parameter.name == 'bind':
        return {'a': 'arm'}
    return parameter.choices[0] if parameter.choices else OF_KIND[parameter.kind]


def call(name: str, by: By = ANN, **given: Any) -> Call:
    return call_of(ask(name, by, **given))


@pytest.mark.parametrize('request_', TABLE, ids=lambda request: request.name)
def test_call_carries_all_arguments_of_request(request_: Any) -> None:
    given: dict[str, Any] = {p.name: value(p) for p in request_.parameters}
    sent = call(request_.name, **given).request
    assert (sent.who, sent.origin, sent.reason) == ('Ann', 'test', 'because')
    assert (sent.role, sent.known) == ('', ''), 'nobody but a door says who somebody is'
    if request_.name == 'queue.add':
        assert (sent.position, sent.held, sent.orders[0].order) == (7, True, 'WO-1')
    else:
        assert (sent.name, arguments_of(sent.arguments)) == (request_.name, given)


def test_orders_without_arguments_ask_for_nothing_more() -> None:
    sent = call('queue.add', orders=[WorkOrder('boxes')]).request
    assert (sent.position, sent.held, sent.orders[0].order) == (0, False, '')


def test_a_door_says_how_it_knows_who_asks() -> None:
    by = By('Ann', 'page', 'because', Role.OPERATE, Known.PAGE_LOGIN)
    sent = call('cell.pause', by).request
    assert (sent.role, sent.known) == ('operate', 'page login')


@pytest.mark.parametrize(
    ('orders', 'message'),
    [
        ([WorkOrder('boxes', 'a', -1)], r'orders\[0\].quantity must be'),
        ([WorkOrder('boxes', 'a', 1, {'a': '\ud800'})], 'not a valid'),
    ],
)
def test_what_no_message_can_carry_is_refused_here(orders: list[WorkOrder], message: str) -> None:
    """The generated code of ROS 2 ends the whole process at some of it."""
    with pytest.raises(CommandRefused, match=message):
        call('queue.add', orders=orders)


def test_lone_surrogate_is_sent_and_node_refuses_it() -> None:
    sent = call('job.hold', job='\udfff').request
    assert sent.arguments == '{"job": "\\udfff"}'
    with pytest.raises(CommandRefused, match='the arguments are not a valid text'):
        arguments_of(sent.arguments)


@pytest.mark.parametrize(
    ('name', 'given'),
    [
        ('job.update', {'job': 'J', 'quantity': -1}),
        ('job.update', {'job': 'J', 'quantity': 10**400}),
        ('job.update', {'job': 'J', 'version': 2**32}),
        ('job.update', {'job': 'J', 'priority': 40_000}),
        ('job.move', {'job': 'J', 'position': -1}),
        ('queue.add', {'orders': [], 'position': 2**40}),
        ('cell.clear', {'as_shown': -1}),
    ],
)
def test_a_number_beyond_its_range_is_no_request(name: str, given: dict[str, Any]) -> None:
    with pytest.raises(BadArguments, match=r'is a whole number from -?\d+ to \d+'):
        call(name, **given)


def test_the_sender_is_checked_too() -> None:
    with pytest.raises(CommandRefused, match='who is not a valid text'):
        call('cell.pause', By('\udcff', 'test', 'because'))


@pytest.mark.parametrize(
    'record', ['{"seq": 7, "time": 0, "event": "new.kind"}', '{"event": "job.held", "new": 1}', '']
)
def test_an_event_of_another_version_is_no_traceback(record: str) -> None:
    with pytest.raises(NodeUnreachable, match=r'event 7 \(.*is the tree node of another version'):
        event_of(Event(seq=7, event='new.kind', record=record))
