"""The panels of the line, as the file of users names them (semantics 7.8)."""

from __future__ import annotations

import ipaddress
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from bt_orchestrator.base.errors import OrchestratorError


class NoSuchChange(OrchestratorError):
    """A user or a panel is there already, or is not there; says what is."""


@dataclass(frozen=True)
class Panels:
    """The panels of the line, from which it can be moved while it is in local (semantics 7.8)."""

    users: tuple[str, ...] = ()
    """Users at a panel, wherever the login comes from."""
    addresses: tuple[str, ...] = ()
    """IP addresses of computers, for users who log in there."""
    certificates: tuple[str, ...] = ()
    """Thumbprints of OPC UA clients, SHA-1 in small letters."""
    keys: tuple[str, ...] = ()
    """Names of keys that sign requests over ROS (semantics 7.12)."""

    def __bool__(self) -> bool:
        return any(True for _ in self)

    def have(self, user: str, address: str = '', certificate: str = '') -> bool:
        """Tell whether a session is at a panel.

        :param address: of the other end of its connection; empty: it proves nothing
        :param certificate: thumbprint of the one that the connection is signed with; empty: none
        """
        return (
            user in self.users
            or _plain_address(address) in self.addresses
            or certificate in self.certificates
        )

    def without(self, kind: str, name: str) -> Panels:
        """Return the panels without one, if it is there."""
        field = PANEL_KINDS[kind]
        kept = tuple(entry for entry in getattr(self, field) if entry != name)
        return replace(self, **{field: kept})

    def changed(self, kind: str, name: str, *, named: bool) -> Panels:
        """Return the panels with one more, or one less.

        :param kind: user, address, certificate or key
        :raises NoSuchChange: the name is none of its kind, or it is named already, or not
        """
        field = PANEL_KINDS[kind]
        name, known = _panel_name(kind, name), getattr(self, field)
        if (name in known) is named:
            is_one = 'is a panel already' if named else 'is no panel'
            raise NoSuchChange(f'the {kind} {name} {is_one}; there are: {self.words or "none"}')
        kept = tuple(other for other in known if other != name)
        return replace(self, **{field: (*kept, name) if named else kept})

    @property
    def words(self) -> str:
        """All panels, for people."""
        return ', '.join(f'{kind} {name}' for kind, name in self)

    def __iter__(self) -> Iterator[tuple[str, str]]:
        for kind, field in PANEL_KINDS.items():
            yield from ((kind, name) for name in getattr(self, field))


PANEL_KINDS = {
    'user': 'users',
    'address': 'addresses',
    'certificate': 'certificates',
    'key': 'keys',
}
"""The kinds of panels, and their keys in the file."""

_THUMBPRINT = re.compile('[0-9a-f]{40}')


def _panel_name(kind: str, name: str) -> str:
    if kind == 'address':
        plain = _plain_address(name)
        if not plain:
            raise NoSuchChange(f'{name!r} is no IP address, as 192.168.3.20 or fe80::1')
        return plain
    thumbprint = name.lower().replace(':', '')
    if kind == 'certificate' and _THUMBPRINT.fullmatch(thumbprint) is None:
        raise NoSuchChange(
            f'{name!r} is no thumbprint of 40 hexadecimal digits; bt-orchestrator opcua trust '
            'lists them'
        )
    return thumbprint if kind == 'certificate' else name


def _plain_address(text: str) -> str:
    """Return an IP address in its usual form; empty: the text names no address."""
    try:
        address = ipaddress.ip_address(text.partition('%')[0])
    except ValueError:
        return ''
    mapped = getattr(address, 'ipv4_mapped', None)
    return str(mapped or address)


def panels_of(plain: Any) -> Panels:
    """Read the panels in the file of users.

    :raises TypeError, NoSuchChange: these are none
    """
    if not isinstance(plain, Mapping) or not set(plain) <= set(PANEL_KINDS.values()):
        raise TypeError(f'expected of panels the keys {", ".join(PANEL_KINDS.values())}')
    panels = Panels()
    for kind, field in PANEL_KINDS.items():
        for name in plain.get(field) or ():
            panels = panels.changed(kind, str(name), named=True)
    return panels
