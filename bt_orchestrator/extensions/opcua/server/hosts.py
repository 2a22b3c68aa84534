"""Names and addresses of this computer, for the certificate of the server."""

from __future__ import annotations

import fcntl
import ipaddress
import socket
import struct
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

_SIOCGIFADDR = 0x8915
_IF_INET6 = Path('/proc/net/if_inet6')

Address = ipaddress.IPv4Address | ipaddress.IPv6Address


def names() -> list[str]:
    """Return the names by which clients may call this computer."""
    found = (socket.gethostname(), socket.getfqdn(), 'localhost')
    return list(dict.fromkeys(name for name in found if name and name.isascii()))


def addresses() -> list[Address]:
    """Return the addresses of every network interface."""
    return list(dict.fromkeys((*_of_version_4(), *_of_version_6())))


def _of_version_4() -> Iterator[Address]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        for _, interface in socket.if_nameindex():
            with suppress(OSError):  # it has no such address
                request = struct.pack('256s', interface.encode()[:15])
                found = fcntl.ioctl(probe.fileno(), _SIOCGIFADDR, request)
                yield ipaddress.IPv4Address(found[20:24])


def _of_version_6() -> Iterator[Address]:
    with suppress(OSError):  # IPv6 is switched off
        for line in _IF_INET6.read_text().splitlines():
            yield ipaddress.IPv6Address(bytes.fromhex(line.split()[0]))
