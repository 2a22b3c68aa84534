"""From a method of OPC UA to the node: once, by the role of the caller."""

from __future__ import annotations

import logging
import secrets
from collections.abc import Mapping
from dataclasses import replace

from asyncua import ua

from bt_orchestrator.extensions.opcua.server import callers
from bt_orchestrator.model import requests
from bt_orchestrator.model.requests import BadArguments, Request, refusal
from bt_orchestrator.ports.doors.tickets import NotSent, Outcome, Tickets, TicketTaken, Unknown

log = logging.getLogger(__name__)


class Calls:
    """All calls come from the server's loop, in the task of a client's session."""

    def __init__(self, tickets: Tickets) -> None:
        self._tickets = tickets

    async def ask(
        self,
        request: Request | str,
        arguments: Mapping[str, object],
        reason: str,
        ticket: str = '',
    ) -> Outcome:
        """Make a request; returns also what the cell refused.

        :param request: or its name, as in `queue.add`
        :param ticket: the same one makes the same command; empty: a new one
        :raises ua.UaStatusCodeError: BadInvalidArgument, BadUserAccessDenied: not sent;
            BadNoCommunication: the node is silent, nothing was sent; BadTimeout: whether it was
            carried out is not known
        """
        name = request if isinstance(request, str) else request.name
        ticket = ticket or secrets.token_hex(8)
        by = callers.by(reason, ticket)
        try:
            asked = requests.ask(name, by, **arguments)
        except BadArguments as error:
            log.warning('%s: %s: %s', by.who, name, error)
            raise ua.UaStatusCodeError(ua.StatusCodes.BadInvalidArgument) from error
        not_allowed = refusal(asked.request, replace(by, reason='any'), asked.arguments)
        if not_allowed is not None:
            log.warning('refused: %s', not_allowed)
            raise ua.UaStatusCodeError(ua.StatusCodes.BadUserAccessDenied)
        try:
            outcome = await self._tickets.carry_out(ticket, asked)
        except (NotSent, Unknown) as error:
            log.warning('%s: %s: %s', by.who, name, error)
            is_unknown = isinstance(error, Unknown)
            bad = ua.StatusCodes.BadTimeout if is_unknown else ua.StatusCodes.BadNoCommunication
            raise ua.UaStatusCodeError(bad) from error
        except TicketTaken as error:
            raise ua.UaStatusCodeError(ua.StatusCodes.BadInvalidArgument) from error
        note = outcome.note('OPC UA server')
        if note:
            log.warning('%s: %s: %s', by.who, name, note)
        done = 'done' if outcome.accepted else 'refused'
        log.info('%s: %s: %s: %s', by.who, name, done, outcome.message)
        return outcome


def reason_of(comment: str, method: str) -> str:
    """Return the reason for the record: what the caller says, or that nothing was said."""
    return comment.strip() or f'no comment (OPC UA {method})'
