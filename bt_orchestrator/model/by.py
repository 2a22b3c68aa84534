"""The sender of a command, with role and ticket, recorded with each command (semantics 7.1)."""

from __future__ import annotations

import re
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

# The rights of users: four roles, and the requests of `model.requests` that each may make.


class Role(Enum):
    """The role of a user."""

    VIEW = 'view'
    """Reads status, events, reports, the past; makes no requests."""
    MES = 'mes'
    """Manages the queue, as an MES does; answers no hold and starts no cell."""
    OPERATE = 'operate'
    """Works at the line."""
    ENGINEER = 'engineer'
    """May do everything."""


# The sender of a command, recorded with each command (semantics 7.1).


class Known(Enum):
    """How sender and role are known."""

    LOCAL_USER = 'local user'
    """The user runs the deciding program itself."""
    PAGE_LOGIN = 'page login'
    OPC_UA_USER = 'opc ua user'
    PAGE_PANEL = 'page panel'
    """As `PAGE_LOGIN`, and at a panel of the line."""
    OPC_UA_PANEL = 'opc ua panel'
    """As `OPC_UA_USER`, and at a panel of the line."""
    SIGNED = 'signed'
    """A key of the person or program has signed the request (semantics 7.12)."""
    SIGNED_PANEL = 'signed panel'
    """As `SIGNED`, and the key is a panel of the line."""
    ROS = 'ros unauthenticated'
    """A participant of the ROS domain claims it, without proof."""

    @property
    def proves_name(self) -> bool:
        """Tell whether the name is authenticated and not only claimed."""
        return self is not Known.ROS

    @property
    def is_door(self) -> bool:
        """Tell whether a program that people log in at knows it, and asks for them."""
        return self in _DOORS

    @property
    def is_panel(self) -> bool:
        """Tell whether it comes from a panel of the line (semantics 7.8).

        The user who runs the deciding program stands at it.
        """
        return self is Known.LOCAL_USER or self in _AT_PANEL.values()

    def at_panel(self) -> Known:
        """Return the same knowledge of somebody who is at a panel."""
        return _AT_PANEL.get(self, self)


_AT_PANEL = {
    Known.PAGE_LOGIN: Known.PAGE_PANEL,
    Known.OPC_UA_USER: Known.OPC_UA_PANEL,
    Known.SIGNED: Known.SIGNED_PANEL,
}
_DOORS = frozenset((*_AT_PANEL, *_AT_PANEL.values())) - {Known.SIGNED, Known.SIGNED_PANEL}


class Signed(NamedTuple):
    """The key that has signed a request, and its number (semantics 7.12)."""

    key: str
    """Its name."""
    public: str
    """Its public part, base64."""
    number: int
    """Rises with each request of the key."""


class Control(Enum):
    """From where the line may be moved (semantics 7.8)."""

    REMOTE = 'remote'
    """From anywhere."""
    LOCAL = 'local'
    """From the panels of the line alone."""


@dataclass(frozen=True)
class By:
    """The sender of a command: name, place, reason."""

    who: str
    origin: str
    """Program, interface or computer that the command came from."""
    reason: str
    role: Role = Role.VIEW
    """The role that permissions are decided by."""
    known: Known = Known.ROS
    claims: str = ''
    """Role that was claimed but is not valid, and its source; empty: none."""
    signed: Signed | None = None
    """None: the request came unsigned."""

    def __str__(self) -> str:
        return f'{self.named}{self._why}'

    def deciding(self, verb: str) -> str:
        """Return a sentence: who decided what, and why."""
        return f'{self.named} decided {verb}{self._why}'

    @property
    def named(self) -> str:
        """The name for display."""
        return named(self.who, self.known.value)

    @property
    def _why(self) -> str:
        return f': {self.reason}' if self.reason else ''


def named(who: str, known: str) -> str:
    """Return a name for display: an unauthenticated one is marked as a claim.

    :param known: a value of `Known`; empty, or another one: it is not known
    """
    if not who:
        return 'somebody'
    return who if known in _PROVEN else f'somebody who claims to be {who}'


_PROVEN = frozenset(known.value for known in Known if known.proves_name)


# Tickets: a program that people log in at numbers their commands, to find them on record later.
#
# A ticket stands in the origin of the command (`By.origin`): `page 0123456789abcdef`.

_TICKET = re.compile(r' ([0-9a-f]{16})(?=$|[ ,])')

WANTED_TICKET = '16 hexadecimal digits in small letters'


def is_ticket(text: str) -> bool:
    """Tell whether a text is a ticket."""
    return _TICKET.fullmatch(f' {text}') is not None


def origin_with(program: str, ticket: str, remark: str = '') -> str:
    """Return the origin of a command with a ticket.

    :param remark: anything else about where it comes from
    """
    return f'{program} {ticket}{f", {remark}" if remark else ""}'


def ticket_in(origin: str) -> str:
    """Return the ticket in an origin; empty: there is none."""
    match = _TICKET.search(origin)
    return match[1] if match else ''


def without_ticket(origin: str) -> str:
    """Return an origin that all commands of its program share."""
    return _TICKET.sub('', origin)
