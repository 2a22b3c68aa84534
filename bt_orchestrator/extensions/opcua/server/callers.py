"""The caller of a method: asyncua hands it none, so each service call of a session sets it.

A method that is a coroutine sees it; one that is an ordinary function runs in another thread and
does not.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass

from bt_orchestrator.model.by import By, Known
from bt_orchestrator.model.limits import cut
from bt_orchestrator.model.roles import Role
from bt_orchestrator.model.ticket import origin_with

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


def by(reason: str, ticket: str) -> By:
    """Return the caller as the sender of a command."""
    caller = CALLER.get()
    origin = origin_with(PROGRAM, ticket, caller.client)
    return By(caller.name, origin, reason, caller.role, Known.OPC_UA_USER)


def client_of(name: str | None, address: str) -> str:
    """Return how a client is called in the origin of commands, and in the log.

    :param name: what it calls itself
    """
    shown = ''.join(char if char.isprintable() else ' ' for char in name or '').strip()
    return f'{cut(shown, LONGEST_CLIENT) or "a client"} at {address}'
