"""Tickets in the origin of commands."""

from __future__ import annotations

import pytest

from bt_orchestrator.model.by import is_ticket, origin_with, ticket_in, without_ticket

TICKET = '0123456789abcdef'


@pytest.mark.parametrize('remark', ['', 'locked session'])
def test_a_ticket_is_found_again(remark: str) -> None:
    origin = origin_with('page', TICKET, remark)
    assert ticket_in(origin) == TICKET
    assert without_ticket(origin) == ('page' if not remark else 'page, locked session')


@pytest.mark.parametrize(
    'origin', ['', 'page', TICKET, 'bt-orchestrator at line-1', f'page {TICKET}0', f'at x{TICKET}']
)
def test_an_origin_without_a_ticket(origin: str) -> None:
    assert ticket_in(origin) == ''
    assert without_ticket(origin) == origin


@pytest.mark.parametrize(
    ('text', 'is_one'),
    [(TICKET, True), (TICKET.upper(), False), (f'{TICKET}\n', False), ('', False), ('12', False)],
)
def test_what_a_ticket_is(text: str, is_one: bool) -> None:
    assert is_ticket(text) is is_one
