"""Connections: how many, how large their messages, and how long without a login."""

from __future__ import annotations

import asyncio
import logging
from collections import Counter

from asyncua.server.binary_server_asyncio import BinaryServer, OPCUAProtocol

from bt_orchestrator.extensions.opcua.server.overrides import limits
from bt_orchestrator.extensions.opcua.server.overrides.inside import Inside
from bt_orchestrator.extensions.opcua.server.overrides.processor import Processor
from bt_orchestrator.ports.spare_log import SpareLog

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
        pending = [one for one in self.clients if isinstance(one, Connection) and one.is_pending]
        if len(pending) <= limits.PENDING:
            return
        busiest, _ = Counter(one.host for one in pending).most_common(1)[0]
        oldest = next(one for one in pending if one.host == busiest)
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
