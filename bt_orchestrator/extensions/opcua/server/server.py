"""The OPC UA server: an address, and a loop in a thread of its own."""

from __future__ import annotations

import asyncio
import logging
import threading
from collections.abc import Awaitable, Callable, Sequence
from datetime import datetime, timezone
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

from asyncua import Server, ua
from asyncua.crypto.permission_rules import PermissionRuleset, User, UserRole
from asyncua.server.user_managers import UserManager
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.extensions.opcua.server import nodesets
from bt_orchestrator.extensions.opcua.server.bridge import Bridge, Part
from bt_orchestrator.extensions.opcua.server.holds import Holds
from bt_orchestrator.extensions.opcua.server.job_control.part import JobControl
from bt_orchestrator.extensions.opcua.server.library import building, give_back
from bt_orchestrator.extensions.opcua.server.nodesets import Access
from bt_orchestrator.extensions.opcua.server.overrides import services
from bt_orchestrator.extensions.opcua.server.overrides.security import People, Person, Security
from bt_orchestrator.extensions.opcua.server.packml import PackML
from bt_orchestrator.extensions.opcua.server.simple import Simple
from bt_orchestrator.extensions.opcua.server.space import Space
from bt_orchestrator.ports.doors.listening import bound, cannot_listen, url_host
from bt_orchestrator.ports.doors.server_thread import ServerThread

log = logging.getLogger(__name__)

PARTS: Sequence[Callable[[Bridge], Part]] = (Simple, JobControl, PackML, Holds)
"""Each is made anew for each cell."""

PLAIN_PARTS: Sequence[Callable[[Bridge], Part]] = (partial(Simple, takes_commands=False),)
"""Those of the plain way."""


class OpcUaServer(ServerThread):
    """States: bound, running, open, ended.

    The port is opened when it is known how the cell stands: before, clients would see that all
    orders are gone.
    """

    def __init__(self, bridge: Bridge, access: Access) -> None:
        """Take the address; clients are refused until the cell is known.

        :raises CannotListen: the address is in use, or none of this computer's
        :raises PkiUnusable: there is no certificate that the server can prove itself with
        """
        self._bridge = bridge
        self._access = access
        self._security = Security.of(bridge.node, access)
        # Keeps the port for the whole life; the stack listens at it with a socket of its own.
        taken = bound(access.host, access.port, lambda _: None, listens=False)
        self._opened = threading.Event()
        super().__init__('opcua', bridge, taken)

    @property
    def address(self) -> str:
        """The answer to a client."""
        return f'opc.tcp://{url_host(self._access.host)}:{self.port}'

    def stop(self) -> None:
        """End it; from any thread."""
        super().stop()
        self._opened.set()

    def wait_until_open(self, within_s: float | None = None) -> bool:
        """Wait until clients can connect, or it was stopped; tells whether it is so."""
        return self._opened.wait(within_s)

    @property
    def is_stopped(self) -> bool:
        """Tell whether it was stopped, or cannot go on."""
        return self._stopped.is_set()

    # --- the thread -------------------------------------------------------------------------

    def _run(self) -> None:
        super()._run()
        self._opened.set()

    async def _serve(self) -> None:
        self._ends = asyncio.Event()
        self._can_end()
        self._bridge.start(self.stop)
        if self._access.plain:
            log.warning('%s; the server shows values, and takes no commands', self._access.plain)
        try:
            while await self._before_end(self._bridge.caught_up()):
                await self._serve_cell()
        finally:
            self._bridge.end()
            self._security.people.close()
            self._socket.close()

    def _end(self) -> None:
        self._ends.set()

    async def _serve_cell(self) -> None:
        """Serve until the end, or until something else exists in the cell."""
        bridge = self._bridge
        with building():
            server = await make_stack(bridge.node, self._security, self.address)
            server.socket_address = self._socket.getsockname()[:2]
            is_plain = bool(self._access.plain)
            loaded = {} if is_plain else await nodesets.load(server, bridge.sources.nodesets)
            bridge.hold_back()
            space = await Space.of(server, bridge.description.cell, loaded)
            parts = [make(bridge) for make in (PLAIN_PARTS if is_plain else PARTS)]
            for part in parts:
                await part.build(space)
        bridge.serve(parts, space.values)
        await space.values.write()
        give_back()
        try:
            await self._listen(server)
            self._opened.set()
            if await self._before_end(bridge.other_cell.wait()):
                log.info('the node has another cell file; clients have to connect again')
        finally:
            bridge.leave()
            space.values.close()
            await server.stop()

    async def _listen(self, server: Server) -> None:
        try:
            await server.start()
        except OSError as error:
            raise cannot_listen(self._access.host, self.port, error) from error

    async def _before_end(self, work: Awaitable[object]) -> bool:
        """Wait for something; tells whether it came before the end."""
        end, task = asyncio.ensure_future(self._ends.wait()), asyncio.ensure_future(work)
        try:
            await asyncio.wait((end, task), return_when=asyncio.FIRST_COMPLETED)
        finally:
            end.cancel()
            task.cancel()
        return not self._ends.is_set()


# The plain way: asyncua's own server, of what asyncua promises to keep, which users only read.
#
# asyncua does not tell a method who calls it, looks at no certificates and sets no limits
# (docs/decisions/0037). So there are no commands, and it is for clients at this computer.


class PlainServer(Server):
    """Users log in, and read."""

    def __init__(self, security: Security) -> None:
        """Prepare; `init` and `start` follow."""
        readers = Readers(security.people)
        super().__init__(user_manager=readers)
        self._own = security.own
        self.set_security_policy(security.policies, Reading(readers))
        self.set_identity_tokens([ua.UserNameIdentityToken])

    async def init(self, shelf_file: Path | None = None) -> None:
        """Load the nodes of every server, and the proof of who it is."""
        with building():
            await super().init(shelf_file)
        await self.set_application_uri(self._own.uri)
        await self.load_certificate(self._own.certificate.public_bytes(Encoding.DER), 'der')
        key = self._own.key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption())
        await self.load_private_key(key, None, 'pem')


class Readers(UserManager):
    """Lets users in by their passwords."""

    def __init__(self, people: People) -> None:
        self._people = people
        self._persons: dict[str, Person] = {}

    def get_user(
        self,
        iserver: Any,
        username: str | None = None,
        password: str | bytes | None = None,
        certificate: Any = None,
    ) -> User | None:
        """Return a user who has said the right password; None: there is none."""
        del iserver, certificate
        if not username or password is None:
            return None
        text = password.decode(errors='replace') if isinstance(password, bytes) else password
        try:
            person = self._people.log_in_here(username, text)
        except OrchestratorError as error:
            log.warning('%s', error)
            return None
        self._persons[person.name] = person
        return User(role=UserRole.User, name=person.name)

    def may_read(self, name: str | None) -> bool:
        """Tell whether a user who was let in is one still, with the same password."""
        person = self._persons.get(name or '')
        return person is not None and self._people.role_of(person) is not None


class Reading(PermissionRuleset):
    """Lets users do what changes nothing."""

    def __init__(self, readers: Readers) -> None:
        self._readers = readers

    def check_validity(self, user: Any, action_type_id: ua.NodeId, body: Any) -> bool:
        """Tell whether a request of somebody is carried out."""
        del body
        return action_type_id in services.READING and self._readers.may_read(user.name)


# The stack of OPC UA with the settings of this server.

PRODUCT = 'urn:bt_orchestrator'


async def make_stack(node: str, security: Security, url: str) -> Server:
    """Return a server without a cell, which does not listen yet."""
    server: Server
    if security.access.plain:
        server = PlainServer(security)
    else:
        from bt_orchestrator.extensions.opcua.server.overrides.server import GuardedServer

        server = GuardedServer(security)
    server.product_uri = PRODUCT
    server.manufacturer_name = 'bt_orchestrator'
    server.set_server_name(f'bt_orchestrator {node}')
    server.application_type = ua.ApplicationType.Server
    await server.init()
    release = version('bt_orchestrator')
    now = datetime.now(timezone.utc)
    await server.set_build_info(
        PRODUCT, 'bt_orchestrator', 'bt_orchestrator', release, release, now
    )
    server.set_endpoint(url)
    return server
