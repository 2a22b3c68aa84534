"""The address at which a program listens, and what is said when it cannot."""

from __future__ import annotations

import contextlib
import errno
import ipaddress
import socket
from collections.abc import Callable

from bt_orchestrator.base.errors import OrchestratorError

LOOPBACK = '127.0.0.1'
"""Where only this computer reaches it."""

Address = ipaddress.IPv4Address | ipaddress.IPv6Address


class CannotListen(OrchestratorError):
    """The address is in use, or not an address of this computer."""


def bound(
    host: str, port: int, prepare: Callable[[socket.socket], object], *, listens: bool = True
) -> socket.socket:
    """Take an address.

    :param prepare: sets what connections inherit
    :param listens: False: connections are refused until `listen` is called
    :raises CannotListen: says why not
    """
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(
            host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
        )[0]
        with contextlib.ExitStack() as stack:
            taken = stack.enter_context(socket.socket(family, kind, protocol))
            taken.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            prepare(taken)
            taken.bind(address)
            if listens:
                taken.listen()
            stack.pop_all()
    except OSError as error:
        raise cannot_listen(host, port, error) from error
    return taken


def cannot_listen(host: str, port: int, error: OSError) -> CannotListen:
    """Return the error in a user's words."""
    if error.errno == errno.EADDRINUSE:
        return CannotListen(
            f'port {port} of {host} is in use by another program; name another --port'
        )
    if error.errno == errno.EACCES:
        return CannotListen(
            f'port {port} of {host} is not for this user; name a --port of 1024 or more'
        )
    return CannotListen(
        f'cannot listen at {host}, port {port}: {error.strerror or error}; see --host'
    )


def is_loopback(address: str) -> bool:
    """Tell whether an address, or `localhost`, is this computer only."""
    known = address_in(address)
    return address == 'localhost' if known is None else known.is_loopback


def is_everywhere(host: str) -> bool:
    """Tell whether an address stands for all those of this computer."""
    address = address_in(host)
    return address is not None and address.is_unspecified


def address_in(text: str) -> Address | None:
    """Read an IP address; None: the text is no address."""
    try:
        address = ipaddress.ip_address(text.strip('[]').partition('%')[0])
    except ValueError:
        return None
    if isinstance(address, ipaddress.IPv6Address) and address.ipv4_mapped is not None:
        return address.ipv4_mapped
    return address


def url_host(host: str) -> str:
    """Return a host as it stands in a URL."""
    return f'[{host}]' if ':' in host else host
