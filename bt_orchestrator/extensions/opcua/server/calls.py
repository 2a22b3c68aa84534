"""From a method of OPC UA to the node: once, by the role of the caller."""

from __future__ import annotations

import logging
import secrets
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace
from typing import Any

import asyncua
from asyncua import ua
from asyncua.common.ua_utils import data_type_to_variant_type

from bt_orchestrator.model import requests
from bt_orchestrator.model.by import By, Known, Role, origin_with
from bt_orchestrator.model.limits import cut
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
        by = by_caller(reason, ticket)
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


# The caller of a method: asyncua hands it none, so each service call of a session sets it.
#
# A method that is a coroutine sees it; one that is an ordinary function runs in another thread
# and does not.

PROGRAM = 'opcua'
"""In the origin of each command."""

LONGEST_CLIENT = 120
"""Characters of the name of a client that are kept."""


@dataclass(frozen=True)
class Caller:
    """A user, at a client."""

    name: str
    role: Role
    """As the file of users says now."""
    client: str
    """Name and address of the program; the name is what it says of itself."""
    session: str = ''
    """Unique among the sessions of the server."""
    is_panel: bool = False
    """It is at a panel of the line (semantics 7.8)."""


CALLER: ContextVar[Caller] = ContextVar('caller')
"""LookupError: there is no caller; the server itself is at work."""


@contextmanager
def calling(caller: Caller) -> Iterator[None]:
    """Do something for a caller."""
    token = CALLER.set(caller)
    try:
        yield
    finally:
        CALLER.reset(token)


def by_caller(reason: str, ticket: str) -> By:
    """Return the caller as the sender of a command."""
    caller = CALLER.get()
    origin = origin_with(PROGRAM, ticket, caller.client)
    known = Known.OPC_UA_USER
    return By(
        caller.name, origin, reason, caller.role, known.at_panel() if caller.is_panel else known
    )


def client_of(name: str | None, address: str) -> str:
    """Return how a client is called in the origin of commands, and in the log.

    :param name: what it calls itself
    """
    text = cut(name or '', LONGEST_CLIENT)
    shown = ''.join(char if char.isprintable() else ' ' for char in text).strip()
    return f'{shown or "a client"} at {address}'


# The arguments of methods: as they are declared, and whether a call fits them.

_KIND = ua.VariantType
_MAY_BE_NULL = (_KIND.String, _KIND.LocalizedText)


@dataclass(frozen=True)
class Argument:
    """An argument of a method, or an output."""

    name: str
    type: ua.VariantType
    """`Variant`: it may have a value of every type."""
    meaning: str
    is_list: bool = False
    is_optional: bool = False
    """Of a method that had fewer arguments before; clients that know it so leave it out."""
    structure: type | None = None
    """The class of a structure."""

    def accepts(self, given: ua.Variant) -> bool:
        """Tell whether a value is of its type; null is an empty text, or no list."""
        if given.VariantType is _KIND.Null:
            return self.is_list or self.type in _MAY_BE_NULL
        if self.is_list and given.Value is None:
            return True
        if self.type is _KIND.Variant:
            return True
        if given.VariantType is not self.type or given.is_array is not self.is_list:
            return False
        several = given.Value if self.is_list else [given.Value]
        return self.structure is None or all(
            isinstance(value, self.structure) for value in several
        )

    def value_of(self, given: ua.Variant) -> Any:
        """Return the value for the method; a text is never null."""
        if self.is_list:
            return (
                [text or '' for text in given.Value or ()] if self._is_text else given.Value or []
            )
        return given.Value or '' if self._is_text else given.Value

    @property
    def _is_text(self) -> bool:
        return self.type is _KIND.String

    @property
    def declared(self) -> ua.Argument:
        """As clients read it."""
        declared = ua.Argument()
        declared.Name = self.name
        declared.DataType = ua.NodeId(self.type.value)
        declared.ValueRank = 1 if self.is_list else -1
        declared.ArrayDimensions = [0] if self.is_list else []
        declared.Description = ua.LocalizedText(self.meaning)
        return declared


async def declared_at(server: asyncua.Server, method: asyncua.Node) -> list[Argument]:
    """Return the arguments that a nodeset declares for a method."""
    names = {
        description.BrowseName.Name: description
        for description in await method.get_children_descriptions()
    }
    if 'InputArguments' not in names:
        return []
    return [
        Argument(
            argument.Name or '',
            await data_type_to_variant_type(server.get_node(argument.DataType)),
            '',
            is_list=argument.ValueRank >= 1,
            structure=ua.extension_objects_by_datatype.get(argument.DataType),
        )
        for argument in await server.get_node(names['InputArguments'].NodeId).read_value()
    ]


def wrong(inputs: Sequence[Argument], given: Sequence[ua.Variant]) -> ua.CallMethodResult | None:
    """Return what is wrong with arguments, argument by argument; None: nothing."""
    if len(given) < sum(not argument.is_optional for argument in inputs):
        return with_status(ua.StatusCodes.BadArgumentsMissing)
    if len(given) > len(inputs):
        return with_status(ua.StatusCodes.BadTooManyArguments)
    codes = [
        ua.StatusCodes.Good if argument.accepts(value) else ua.StatusCodes.BadTypeMismatch
        for argument, value in zip(inputs, given, strict=False)
    ]
    if not any(codes):
        return None
    result = with_status(ua.StatusCodes.BadInvalidArgument)
    result.InputArgumentResults = [ua.StatusCode(code) for code in codes]
    return result


def with_status(code: int) -> ua.CallMethodResult:
    """Return the result of a call that has no outputs."""
    result = ua.CallMethodResult()
    result.StatusCode = ua.StatusCode(code)
    return result
