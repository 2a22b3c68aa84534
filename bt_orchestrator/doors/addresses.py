"""Addresses that a program listens at, and those of callers."""

from __future__ import annotations

import ipaddress

LOOPBACK = '127.0.0.1'


def address_of(text: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    """Return an address that was written as one, also in brackets; None: it is a name."""
    try:
        address = ipaddress.ip_address(text.strip('[]').partition('%')[0])
    except ValueError:
        return None
    if isinstance(address, ipaddress.IPv6Address) and address.ipv4_mapped is not None:
        return address.ipv4_mapped
    return address


def is_loopback(address: str) -> bool:
    """Tell whether an address, or `localhost`, is this computer only."""
    known = address_of(address)
    return address == 'localhost' if known is None else known.is_loopback


def is_everywhere(host: str) -> bool:
    """Tell whether to listen there is to listen at every address of the computer."""
    address = address_of(host)
    return address is not None and address.is_unspecified
