"""Every request of the table has its call of a service; what the node says is read, or refused."""

from __future__ import annotations

from typing import Any

import pytest
from bt_orchestrator_interfaces.msg import Event

from bt_orchestrator.errors import CommandRefused, NodeUnreachable
from bt_orchestrator.model.by import By, Known
from bt_orchestrator.model.jobs.order import WorkOrder
from bt_orchestrator.model.requests import TABLE, Kind, Parameter, ask
from bt_orchestrator.model.roles import Role
from bt_orchestrator.ros.link.requests import Call, call_of
from bt_orchestrator.ros.link.ros_link import event_of

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
def test_a_request_with_all_its_arguments_is_a_call(request_: Any) -> None:
    given: dict[str, Any] = {p.name: value(p) for p in request_.parameters}
    sent = call(request_.name, **given).request
    assert (sent.who, sent.origin, sent.reason) == ('Ann', 'test', 'because')
    assert (sent.role, sent.known) == ('', ''), 'nobody but a door says who somebody is'
    words = str(sent)
    for parameter in request_.parameters:
        assert str(given[parameter.name]) in words or parameter.kind not in (Kind.TEXT, Kind.WHOLE)


def test_a_request_without_arguments_asks_for_nothing_more() -> None:
    sent = call('job.update', job='J', quantity=3).request
    assert (sent.script, sent.params, sent.details) == ('', [], '')
    assert list(sent.priority) == list(sent.start) == []
    sent = call('queue.add', orders=[WorkOrder('boxes')]).request
    assert (sent.position, sent.held, sent.orders[0].order) == (0, False, '')
    assert call('hold.mark_done', hold='1').request.results == ''


def test_a_door_says_how_it_knows_who_asks() -> None:
    by = By('Ann', 'page', 'because', Role.OPERATE, Known.PAGE_LOGIN)
    sent = call('cell.pause', by).request
    assert (sent.role, sent.known) == ('operate', 'page login')


@pytest.mark.parametrize(
    ('name', 'given', 'told'),
    [
        ('job.update', {'quantity': -1}, 'quantity must be a whole number from 0 to 4294967295'),
        ('job.update', {'quantity': 2**32}, 'quantity must be a whole number'),
        ('job.update', {'quantity': 10**400}, 'quantity must be a whole number'),
        ('job.update', {'version': -1}, 'version must be a whole number'),
        ('job.update', {'priority': 40_000}, 'job.update cannot be sent: '),
        ('job.update', {'bind': {'a': None}}, r'bind\[0\].value must be text'),
        ('job.update', {'bind': {'a': 1}}, r'bind\[0\].value must be text'),
        ('job.update', {'params': {'a': '\ud800'}}, r'params\[0\].value is not a valid text'),
        ('job.update', {'start': '9999-12-31T23:59Z'}, 'start'),
        ('job.move', {'position': -1}, 'position must be a whole number'),
        ('job.hold', {'job': '\udfff'}, 'job is not a valid text'),
        ('queue.add', {'orders': [WorkOrder('boxes', 'a', -1)]}, r'orders\[0\].quantity must be'),
        ('queue.add', {'orders': [WorkOrder('boxes', 'a', 1, {'a': '\ud800'})]}, 'not a valid'),
        ('queue.add', {'orders': [], 'position': 2**40}, 'position must be a whole number'),
        ('cell.clear', {'as_shown': -1}, 'as_shown must be a whole number'),
    ],
)
def test_what_no_message_can_carry_is_refused_here(
    name: str, given: dict[str, Any], told: str
) -> None:
    """The generated code of ROS 2 ends the whole process at some of it."""
    subject = {'job': 'J'} if name.startswith('job.') else {}
    with pytest.raises(CommandRefused, match=told):
        call(name, **{**subject, **given})


def test_the_sender_is_checked_too() -> None:
    with pytest.raises(CommandRefused, match='who is not a valid text'):
        call('cell.pause', By('\udcff', 'test', 'because'))


@pytest.mark.parametrize(
    'record', ['{"seq": 7, "time": 0, "event": "new.kind"}', '{"event": "job.held", "new": 1}', '']
)
def test_an_event_of_another_version_is_no_traceback(record: str) -> None:
    with pytest.raises(NodeUnreachable, match=r'event 7 \(.*is the tree node of another version'):
        event_of(Event(seq=7, event='new.kind', record=record))
