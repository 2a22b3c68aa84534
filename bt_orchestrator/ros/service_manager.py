"""Messages to systemd about the node that it runs: the protocol of sd_notify(3)."""

from __future__ import annotations

import os
import socket
from contextlib import suppress

READY = 'READY=1'
ALIVE = 'WATCHDOG=1'
STOPPING = 'STOPPING=1'

_SOCKET = 'NOTIFY_SOCKET'


def is_told() -> bool:
    """Tell whether a service manager listens."""
    return bool(os.environ.get(_SOCKET))


LONG_S = 300
"""Patience of the watchdog while a standby reads the journal that it goes on with."""


def watchdog(*, patient: bool) -> str:
    """Return the line that makes the watchdog patient, or as it was."""
    usual = os.environ.get('WATCHDOG_USEC', '')
    return f'WATCHDOG_USEC={LONG_S * 1_000_000 if patient else usual}' if usual else ''


def tell(*lines: str) -> None:
    """Tell the service manager something; without one nothing happens.

    It must not hold up or stop a cell: what cannot be sent at once is not sent.
    """
    address = os.environ.get(_SOCKET, '')
    if not address:
        return
    if address.startswith('@'):  # an abstract name, which begins with a zero
        address = f'\0{address[1:]}'
    kind = socket.SOCK_DGRAM | socket.SOCK_CLOEXEC | socket.SOCK_NONBLOCK
    with suppress(OSError), socket.socket(socket.AF_UNIX, kind) as manager:
        manager.sendto('\n'.join(filter(None, lines)).encode(), address)
