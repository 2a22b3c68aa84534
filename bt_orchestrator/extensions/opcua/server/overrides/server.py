"""The server, made of the overridden parts."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections import Counter
from pathlib import Path
from typing import Any

import asyncua
from asyncua import ua
from asyncua.common.connection import TransportLimits
from asyncua.server.binary_server_asyncio import BinaryServer, OPCUAProtocol

from bt_orchestrator.extensions.opcua.server.library import building
from bt_orchestrator.extensions.opcua.server.overrides import limits
from bt_orchestrator.extensions.opcua.server.overrides.inside import Inside
from bt_orchestrator.extensions.opcua.server.overrides.processor import Processor
from bt_orchestrator.extensions.opcua.server.overrides.security import Security
from bt_orchestrator.ports.spare_log import SpareLog

log = logging.getLogger(__name__)

LOOK_S = 1.0
"""Between two looks at whether somebody was removed who is connected."""

_NODES = {
    'MaxNodesPerRead': limits.NODES,
    'MaxNodesPerWrite': limits.NODES,
    'MaxNodesPerMethodCall': limits.CALLED,
    'MaxNodesPerBrowse': limits.BROWSED,
    'MaxNodesPerTranslateBrowsePathsToNodeIds': limits.BROWSED,
    'MaxMonitoredItemsPerCall': limits.NODES,
}


class GuardedServer(asyncua.Server):
    """asyncua's server with users, trust and limits."""

    def __init__(self, security: Security) -> None:
        """Prepare; `init` and `start` follow."""
        self.inside = Inside(security)
        super().__init__(iserver=self.inside)
        self.limits = TransportLimits(
            max_recv_buffer=limits.CHUNK_BYTES,
            max_send_buffer=limits.CHUNK_BYTES,
            max_chunk_count=limits.MESSAGE_BYTES // limits.SMALLEST_CHUNK_BYTES + 1,
            max_message_size=limits.MESSAGE_BYTES,
        )
        self._security = security
        self.set_security_policy(security.policies)
        self._watch: asyncio.Task[None] | None = None

    async def init(self, shelf_file: Path | None = None) -> None:
        """Load the nodes of every server; clients can read the limits."""
        with building():
            await super().init(shelf_file)
        await self.set_application_uri(self._security.own.uri)
        for name, most in _NODES.items():
            node = self.get_node(
                ua.NodeId(
                    getattr(ua.ObjectIds, f'Server_ServerCapabilities_OperationLimits_{name}')
                )
            )
            await node.write_value(most, ua.VariantType.UInt32)

    async def import_xml(self, *args: Any, **options: Any) -> list[ua.NodeId]:
        """Load a nodeset; it may have types of references of its own."""
        nodes = await super().import_xml(*args, **options)
        self.inside.view_service.forget()
        return nodes

    async def start(self) -> None:
        """Listen.

        asyncua makes its `BinaryServer` here, by name; otherwise this is what it does.
        """
        self.inside.view_service.forget()
        await self._setup_server_nodes()
        await self.iserver.start()
        host, port = self._get_bind_socket_info()
        self.bserver = Listener(self.inside, host or '', port or 0, self.limits)
        self.bserver.set_policies(self._policies)
        try:
            await self.bserver.start()
        except OSError:
            await self.iserver.stop()
            raise
        self._watch = asyncio.create_task(self._look_again())

    async def stop(self) -> None:
        """End all connections."""
        if self._watch is not None:
            self._watch.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._watch
        await super().stop()

    async def _look_again(self) -> None:
        """End sessions of users and certificates that were removed.

        A client whose requests for news wait here needs no further one to be told something.
        """
        while True:
            await asyncio.sleep(LOOK_S)
            for session in self.inside.sessions:
                why = session.why_not(self._security)
                if why:
                    await session.end(why)
                    if session.transport is not None:
                        session.transport.close()


# Connections: how many, how large their messages, and how long without a login.

_HEADER_BYTES = 8

spare = SpareLog(logging.getLogger(__name__))


class Connection(OPCUAProtocol):
    """One connection of a client."""

    iserver: Inside
    processor: Processor | None
    _buffer: bytes

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Begin, with the processor that is ours."""
        super().connection_made(transport)
        if self.processor is None:  # there are too many
            return
        self.processor = Processor(self.iserver, self.transport, self.limits)
        self.processor.set_policies(self.policies)
        self._make_room()

    def data_received(self, data: bytes) -> None:
        """Take bytes; asyncua would wait for as many as a header announces, up to 4 GB."""
        super().data_received(data)
        if len(self._buffer) >= _HEADER_BYTES and self.transport is not None:
            announced = int.from_bytes(self._buffer[4:8], 'little')
            if not _HEADER_BYTES < announced <= limits.CHUNK_BYTES:
                spare.warning(
                    f'{self.peer_name} announces a part of {announced} bytes, and '
                    f'{limits.CHUNK_BYTES} is the most; its connection is closed'
                )
                self._buffer = b''
                self.transport.abort()

    @property
    def is_pending(self) -> bool:
        """Tell whether the login is still missing."""
        session = None if self.processor is None else self.processor.session
        return session is None or not session.is_activated()

    @property
    def host(self) -> str:
        return str(self.peer_name[0]) if self.peer_name else ''

    def _make_room(self) -> None:
        """Close an old connection when too many wait for a login."""
        pending = [
            client
            for client in self.clients
            if isinstance(client, Connection) and client.is_pending
        ]
        if len(pending) <= limits.PENDING:
            return
        busiest, _ = Counter(connection.host for connection in pending).most_common(1)[0]
        oldest = next(connection for connection in pending if connection.host == busiest)
        spare.warning(
            f'more than {limits.PENDING} connections wait for a login; the oldest one from '
            f'{busiest} is closed'
        )
        if oldest.transport is not None:
            self.clients.remove(oldest)
            oldest.transport.abort()


class Listener(BinaryServer):
    """The socket."""

    iserver: Inside

    def _make_protocol(self) -> OPCUAProtocol:
        return Connection(
            iserver=self.iserver,
            policies=self._policies,
            clients=self.clients,
            closing_tasks=self.closing_tasks,
            limits=self.limits,
        )
