"""Tickets: a program that people log in at numbers their commands, to find them on record later.

A ticket stands in the origin of the command (`By.origin`): `page 0123456789abcdef`.
"""

from __future__ import annotations

import re

_TICKET = re.compile(r' ([0-9a-f]{16})(?=$|[ ,])')

WANTED = '16 hexadecimal digits in small letters'


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
    found = _TICKET.search(origin)
    return found[1] if found else ''


def without_ticket(origin: str) -> str:
    """Return an origin that all commands of its program share."""
    return _TICKET.sub('', origin)
