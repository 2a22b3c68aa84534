"""Where the page listens and whom it lets in: options, and what they must be together."""

from __future__ import annotations

import ssl
from dataclasses import dataclass, field
from pathlib import Path

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.ports.doors.listening import LOOPBACK, address_in, is_everywhere, is_loopback
from bt_orchestrator.script.users.file import KnownUsers, UsersUnusable

IDLE_S = 15 * 60.0
"""Without a command or a sign of life for so long, a session is locked."""

SESSION_S = 12 * 3600.0
"""A session ends so long after its login: a shift and a bit."""


class AccessRefused(OrchestratorError):
    """The page does not start like this; the message says why, and what to do."""


@dataclass(frozen=True)
class Access:
    """The people who reach the page, and how the page knows them."""

    users: Path
    """File of the users and their roles (`script/users/`)."""
    host: str = LOOPBACK
    port: int = 0
    """0: any free one."""
    certificate: Path | None = None
    """PEM; with `key`: the page speaks TLS."""
    key: Path | None = None
    allowed_hosts: tuple[str, ...] = ()
    """Names, besides its own, by which browsers may call the page."""
    local_user: str = ''
    """Any person at this computer is this user, an engineer, without a login; empty: no such user.
    """
    proxy_header: str = ''
    """Header in which a proxy names the user who logged in there; empty: there is no proxy."""
    proxy_addresses: tuple[str, ...] = field(default=())
    """Addresses of the proxy, besides this computer."""
    idle_s: float = IDLE_S
    session_s: float = SESSION_S

    @property
    def is_local(self) -> bool:
        """Tell whether only this computer reaches the page."""
        return is_loopback(self.host)

    @property
    def has_tls(self) -> bool:
        """Tell whether the page speaks TLS itself."""
        return self.certificate is not None

    @property
    def looks_freely(self) -> bool:
        """Tell whether looking needs no login: what a proxy passes on comes from here as well."""
        return self.is_local and not self.proxy_header

    @property
    def cookie(self) -> str:
        """Name of the cookie of a session: browsers do not tell the ports of a computer apart."""
        return f'bt_orchestrator_{self.port}'

    def check(self) -> None:
        """Refuse options that would let in anybody, and a file of users that cannot be read.

        :raises AccessRefused: says what was expected
        """
        self._check_pairs()
        if not self.is_local and self.local_user:
            raise AccessRefused(
                f'--trust-this-computer makes everybody who reaches the page an engineer, and '
                f'--host {self.host} lets others reach it; leave one of the two out'
            )
        if not self.is_local and not self.proxy_header and not self.has_tls:
            raise AccessRefused(
                f'on {self.host} passwords would cross the network in the clear; give '
                '--certificate FILE and --key FILE, or --behind-proxy HEADER if a proxy logs '
                f'people in, or leave --host out: then only this computer ({LOOPBACK}) sees the '
                'page'
            )
        has_users = self._has_users
        if (not self.is_local or self.proxy_header) and not has_users:
            raise AccessRefused(
                f'there are no users in {self.users}; add one, who can look, with: '
                'bt-orchestrator user add NAME --role ROLE'
            )
        self._check_certificate()

    def _check_pairs(self) -> None:
        if (self.certificate is None) != (self.key is None):
            raise AccessRefused('--certificate and --key belong together; give both, or none')
        if self.proxy_addresses and not self.proxy_header:
            raise AccessRefused('--proxy-address says where a proxy is; give --behind-proxy too')
        if self.local_user and self.proxy_header:
            raise AccessRefused(
                '--trust-this-computer would make an engineer of everybody the proxy passes on; '
                'leave it out, or --behind-proxy'
            )
        for address in self.proxy_addresses:
            if address_in(address) is None:
                raise AccessRefused(f'--proxy-address is an IP address; found {address!r}')

    @property
    def _has_users(self) -> bool:
        try:
            return bool(KnownUsers(self.users).all())
        except UsersUnusable as error:
            raise AccessRefused(str(error)) from error

    def _check_certificate(self) -> None:
        if self.certificate is None or self.key is None:
            return
        for path in (self.certificate, self.key):
            if not path.is_file():
                raise AccessRefused(f'{path}: there is no such file; expected PEM')
        try:
            ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER).load_cert_chain(
                self.certificate, self.key, password=''
            )
        except OSError as error:  # ssl.SSLError is one
            raise AccessRefused(
                f'{self.certificate} and {self.key} are no certificate and its key without a '
                f'password, in PEM: {error}'
            ) from error

    # --- who calls ------------------------------------------------------------------------------

    def is_proxy(self, address: str) -> bool:
        """Tell whether the header of the proxy counts in what comes from an address."""
        if not self.proxy_header:
            return False
        known = {address_in(proxy) for proxy in self.proxy_addresses}
        return is_loopback(address) or (
            address_in(address) in known and address_in(address) is not None
        )

    def is_allowed_host(self, name: str) -> bool:
        """Tell whether browsers may call the page by a name, or by an address.

        Names of others are refused: a page of theirs could make its own name mean this computer.
        """
        wanted = name.lower().rstrip('.')
        if wanted in {
            'localhost',
            self.host.lower(),
            *(host.lower() for host in self.allowed_hosts),
        }:
            return True
        address = address_in(wanted)
        if address is None:
            return False
        # An address that was reached is no name that somebody else could have chosen.
        return address.is_loopback or is_everywhere(self.host)
