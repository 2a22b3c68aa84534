"""Commands of people: each request of the table, made by the session that posts it."""

from __future__ import annotations

import asyncio
import logging
import secrets
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from starlette.requests import Request as HttpRequest
from starlette.responses import Response

from bt_orchestrator.base.errors import NodeUnreachable, Refused
from bt_orchestrator.extensions.page.web.endpoint import Endpoint, Json, Problem, body_of
from bt_orchestrator.extensions.page.web.people import Session
from bt_orchestrator.extensions.page.web.request_paths import PLACES, body_at, request_at
from bt_orchestrator.extensions.page.web.wording import said_in_each
from bt_orchestrator.model.by import WANTED_TICKET, By, is_ticket, origin_with
from bt_orchestrator.model.jobs.order import WorkOrder
from bt_orchestrator.model.limits import NAME, ORDERS, REASON
from bt_orchestrator.model.requests import REQUESTS, Asked, BadArguments, Why, ask, refusal
from bt_orchestrator.model.words import sentence
from bt_orchestrator.ports.doors.tickets import NotSent, Outcome, Tickets, TicketTaken, Unknown
from bt_orchestrator.script.orders.plain_order import order_from

log = logging.getLogger(__name__)

PROGRAM = 'page'
"""In the origin of each command."""

REFUSALS: Mapping[int, str] = {
    401: 'log in first',
    403: 'the role of the session does not allow it, or the session is locked',
    409: 'the cell refuses it; `message` is its sentence, `said` the same by language',
    422: 'the body does not fit the request; `message` says what was expected',
    503: 'the node is silent, or did not answer; GET /api/tickets/{ticket} tells more',
}


def endpoints(tickets: Tickets) -> Sequence[Endpoint]:
    """Return the endpoints of all requests, and of tickets."""
    commands = Commands(tickets)
    return (
        *(
            Endpoint(
                'POST', path, partial(commands.answer, path), place.does, refusals=REFUSALS,
                **body_at(path),
            )
            for path, place in PLACES.items()
        ),
        Endpoint(
            'POST', '/api/at_panel', commands.stay,
            'says that somebody is at this panel, while a task of manual mode runs',
            refusals=REFUSALS,
        ),
        Endpoint(
            'GET', '/api/tickets/{ticket}', commands.find,
            'what became of a command, from the journal if the page does not know',
            refusals={422: 'no ticket'},
        ),
    )  # fmt: skip


class Commands:
    """Makes requests of what is posted."""

    def __init__(self, tickets: Tickets) -> None:
        self._tickets = tickets

    async def answer(self, path: str, http: HttpRequest) -> Response:
        """Carry out what was posted to the path of some requests."""
        session: Session = http.state.session
        body = await body_of(http)
        ticket = _ticket(body)
        given = {**body, **http.path_params}
        # Reading many orders takes long, and others want their stream meanwhile.
        asked = await asyncio.to_thread(_asked, path, given, session, ticket)
        _check(asked, session)
        try:
            outcome = await self._tickets.carry_out(ticket, asked)
        except (NotSent, Unknown) as error:
            log.warning('%s: %s: %s', asked.sender.who, asked.request.name, error)
            is_unknown = isinstance(error, Unknown)
            raise Problem(503, str(error), ticket=ticket, is_unknown=is_unknown) from error
        except TicketTaken as error:
            raise Problem(422, str(error)) from error
        done = 'done' if outcome.accepted else 'refused'
        log.info('%s: %s: %s: %s', asked.sender.who, asked.request.name, done, outcome.message)
        return Json(_told(ticket, outcome), 200 if outcome.accepted else 409)

    async def stay(self, http: HttpRequest) -> Response:
        """Hand on a sign of life: it is not on record, so no ticket is kept of it."""
        session: Session = http.state.session
        by = By(session.name, PROGRAM, '', session.role, session.known)
        asked = Asked(REQUESTS['cell.at_panel'], by)
        _check(asked, session)
        try:
            answer = await self._tickets.doors.ask(asked)
        except NodeUnreachable as error:
            raise Problem(503, str(error)) from error
        words = {'message': answer.message, 'said': said_in_each(answer.message)}
        return Json({'accepted': answer.accepted, **words}, 200 if answer.accepted else 409)

    async def find(self, http: HttpRequest) -> Response:
        """Tell what became of a command."""
        ticket = http.path_params['ticket']
        if not is_ticket(ticket):
            raise Problem(422, f'a ticket is {WANTED_TICKET}')
        search = await self._tickets.find(ticket)
        if search.outcome is not None:
            return Json({'found': True, **_told(ticket, search.outcome)})
        return Json(
            {
                'found': False,
                'ticket': ticket,
                'looked_from': search.first,
                'looked_to': search.last,
                'node_silent': search.is_silent,
            }
        )


# --- what is asked ------------------------------------------------------------------------------


def _ticket(body: dict[str, Any]) -> str:
    """Take the ticket out of a body; who sends none gets one."""
    ticket = body.pop('ticket', None) or secrets.token_hex(8)
    if not isinstance(ticket, str) or not is_ticket(ticket):
        raise Problem(422, f'ticket is {WANTED_TICKET}; found {ticket!r:.100}')
    return ticket


def _asked(path: str, given: dict[str, Any], session: Session, ticket: str) -> Asked:
    """Return the request that was posted, with the session as its sender."""
    given.pop('who', None)  # the session says it
    reason = given.pop('reason', '')
    if not isinstance(reason, str) or len(reason) > REASON:
        raise Problem(422, f'reason is a text of at most {REASON} characters')
    remark = 'locked session' if session.is_locked else ''
    origin = origin_with(PROGRAM, ticket, remark)
    by = By(session.name, origin, reason, session.role, session.known)
    try:
        request = request_at(path, given)
        _check_texts(given)
        if request.takes_orders:
            given['orders'] = _orders(given.get('orders'))
        return ask(request.name, by, **given)
    except BadArguments as error:
        raise Problem(422, str(error)) from error


def _check_texts(given: Mapping[str, Any]) -> None:
    for name, text in given.items():
        if isinstance(text, str) and len(text) > NAME:
            words = sentence('too_many_characters', field=name, count=len(text), most=NAME)
            raise Problem(422, words)


def _orders(plain_orders: Any) -> list[WorkOrder]:
    """Read the orders of a request.

    An order needs an id: if it is sent again because an answer was lost, nothing is made twice.
    """
    if not isinstance(plain_orders, list) or not 1 <= len(plain_orders) <= ORDERS:
        raise Problem(422, f'orders is a list of 1 to {ORDERS} work orders')
    orders = []
    for plain in plain_orders:
        if not isinstance(plain, dict) or not plain.get('order'):
            raise Problem(422, 'each work order is an object, and needs an id of its own: `order`')
        try:
            orders.append(order_from(plain))
        except Refused as refused:
            findings = [str(finding) for finding in refused.findings]
            raise Problem(422, refused.in_short, findings=findings) from refused
    return orders


def _check(asked: Asked, session: Session) -> None:
    """Refuse early what the node would refuse: an emergency is for a locked session as well."""
    request = asked.request
    if session.is_locked and request.why is not Why.AFTERWARDS:
        raise Problem(403, sentence('session_locked'), why='locked')
    not_allowed = refusal(request, replace(asked.sender, reason='any'), asked.arguments)
    if not_allowed is not None:
        log.warning('refused: %s', not_allowed)
        raise Problem(403, not_allowed)
    without_reason = refusal(request, asked.sender, asked.arguments)
    if without_reason is not None:
        raise Problem(422, without_reason)


# --- what came of it ----------------------------------------------------------------------------


def _told(ticket: str, outcome: Outcome) -> dict[str, object]:
    recorded = outcome.recorded[0] if outcome.recorded else None
    decision: dict[str, object] = (
        {}
        if recorded is None
        else {
            'seq': recorded.seq,
            'who': recorded.who,
            'role': recorded.role,
            'known': recorded.known,
            'claims': recorded.claims,
        }
    )
    return {
        'accepted': outcome.accepted,
        'message': outcome.message,
        'said': said_in_each(outcome.message),
        'findings': outcome.findings,
        'ticket': ticket,
        'seq': decision.get('seq'),
        'who': decision.get('who', ''),
        'recorded': decision or None,
        'note': outcome.note(PROGRAM),
    }
