"""Sessions: who logged in, with which certificate, and what they may use."""

from __future__ import annotations

import asyncio
import logging
import secrets
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from asyncua import ua
from asyncua.common.utils import ServiceError
from asyncua.crypto.permission_rules import User, UserRole
from asyncua.server.internal_session import SessionState

from bt_orchestrator.extensions.opcua.server.client_certificates import Untrusted
from bt_orchestrator.extensions.opcua.server.overrides import limits
from bt_orchestrator.extensions.opcua.server.overrides.own_subscriptions import (
    OwnSubscriptions,
    check_count,
    check_same,
)
from bt_orchestrator.extensions.opcua.server.overrides.security import Person

if TYPE_CHECKING:
    from bt_orchestrator.extensions.opcua.server.overrides.security import Security

log = logging.getLogger(__name__)


class Session(OwnSubscriptions):
    """The session of a client; it may outlive its connection, and go on at another one."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        # asyncua counts: others could guess it.
        self.iserver.unregister_external_session(self)
        self.auth_token = ua.NodeId(secrets.token_bytes(32), 0, ua.NodeIdType.ByteString)
        self.iserver.register_external_session(self)
        self.certificate = b''
        """Of the connection on which it was made; empty: that is not encrypted."""
        self.client = ''
        """Name and address of the program."""
        self.person: Person | None = None
        """None: there is no login."""
        self.let_in: Person | None = None
        """The user who is about to log in."""
        self.transport: asyncio.Transport | None = None
        """Of the connection that it goes on at."""
        self._trusted_at: object = None

    def activate_session(
        self, params: ua.ActivateSessionParameters, peer_certificate: bytes | None
    ) -> ua.ActivateSessionResult:
        """Let somebody in whose password was checked."""
        if self.let_in is None:
            raise ServiceError(ua.StatusCodes.BadUserAccessDenied)
        result = super().activate_session(params, peer_certificate)
        self.person = self.let_in
        self.user = User(role=UserRole.User, name=self.person.name)
        return result

    def why_not(self, security: Security) -> str:
        """Say why a user who was let in may not go on; empty: the user may."""
        if self.person is None:
            return ''
        if security.people.role_of(self.person) is None:
            return f'{self.person.name} was removed from the users, or has another password'
        version = security.trust.version
        if self.certificate and version != self._trusted_at:
            try:
                security.trust.check(self.certificate)
            except Untrusted as error:
                return str(error)
            self._trusted_at = version
        return ''

    async def end(self, why: str) -> None:
        """End it; the next request of a client gets the reason."""
        log.warning('session of %s at %s ended: %s', self.user.name, self.client, why)
        await self.close_session(True)

    @property
    def is_open(self) -> bool:
        """Tell whether it was not closed."""
        return self.state is not SessionState.Closed

    # --- requests that are too large ------------------------------------------------------------

    async def read(self, params: ua.ReadParameters) -> list[ua.DataValue]:
        """Read some attributes."""
        check_count(params.NodesToRead, limits.NODES)
        check_same(params.NodesToRead)
        results = []
        for step in _steps(params.NodesToRead):
            results += await super().read(replace(params, NodesToRead=step))
            await asyncio.sleep(0)
        return results

    async def write(self, params: ua.WriteParameters) -> list[ua.StatusCode]:
        """Write some attributes."""
        check_count(params.NodesToWrite, limits.NODES)
        return await super().write(params)

    async def browse(self, params: ua.BrowseParameters) -> list[ua.BrowseResult]:
        """Return references of some nodes."""
        check_count(params.NodesToBrowse, limits.BROWSED)
        results = []
        for step in _steps(params.NodesToBrowse):
            results += await super().browse(replace(params, NodesToBrowse=step))
            await asyncio.sleep(0)
        return results

    async def translate_browsepaths_to_nodeids(
        self, params: list[ua.BrowsePath]
    ) -> list[ua.BrowsePathResult]:
        """Find some nodes."""
        check_count(params, limits.BROWSED)
        results = []
        for step in _steps(params):
            results += await super().translate_browsepaths_to_nodeids(step)
            await asyncio.sleep(0)
        return results

    async def call(self, params: list[ua.CallMethodRequest]) -> list[ua.CallMethodResult]:
        """Call some methods."""
        check_count(params, limits.CALLED)
        return await super().call(params)


def _steps(given: Sequence[Any] | None) -> Iterator[list[Any]]:
    """Yield what is given in steps, between which others get their turn."""
    things = given or []
    for first in range(0, len(things), limits.STEP):
        yield list(things[first : first + limits.STEP])
