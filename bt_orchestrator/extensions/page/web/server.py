"""The server of the page: a socket, and a loop in a thread of its own."""

from __future__ import annotations

import asyncio
import socket
from typing import Any

import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol

from bt_orchestrator.extensions.page.web.app import make_app
from bt_orchestrator.extensions.page.web.page import WebPage
from bt_orchestrator.extensions.page.web.stream import PIECE, SEND_LIMIT_S
from bt_orchestrator.ports.doors.listening import bound, url_host
from bt_orchestrator.ports.doors.server_thread import ServerThread

SEND_BUFFER = 64 * 1024
"""Of each connection in the kernel, bytes: a reader that is stuck is noticed, and costs little."""

FIRST_WITHIN_S = 20.0
"""A connection that has asked for nothing after so long is ended."""

FAREWELL_S = 1
"""Longest wait for requests that are carried out while the page ends."""


class PageServer(ServerThread):
    """States: bound, running, ended."""

    def __init__(self, page: WebPage) -> None:
        """Take the address; requests wait until it runs.

        :raises CannotListen: the address is in use, or none of this computer's
        """
        self._page = page
        taken = bound(page.access.host, page.access.port, _prepare)
        super().__init__('page', page, taken)

    @property
    def address(self) -> str:
        """The address for a browser."""
        host, has_tls = self._page.access.host, self._page.access.has_tls
        scheme = 'https' if has_tls else 'http'
        return f'{scheme}://{url_host(host)}:{self.port}/'

    async def _serve(self) -> None:
        page = self._page
        page.start(self.stop)
        config = uvicorn.Config(
            make_app(page),
            http=Protocol,
            ws='none',
            loop='asyncio',
            lifespan='off',
            log_config=None,
            log_level='error',
            access_log=False,
            proxy_headers=False,
            server_header=False,
            ssl_certfile=page.access.certificate,
            ssl_keyfile=page.access.key,
            timeout_graceful_shutdown=FAREWELL_S,
        )
        self._uvicorn = uvicorn.Server(config)
        self._can_end()
        try:
            await self._uvicorn.serve(sockets=[self._socket])
        finally:
            page.end()
            self._socket.close()  # uvicorn does so only if it came to serve

    def _end(self) -> None:
        self._page.end()
        self._uvicorn.should_exit = True
        asyncio.get_running_loop().call_later(0.7 * FAREWELL_S, self._cut)

    def _cut(self) -> None:
        """End what is left of connections: over TLS a client may never say farewell."""
        connections: set[Any] = {*self._uvicorn.server_state.connections}
        for connection in connections:
            connection.transport.abort()


class Protocol(H11Protocol):
    """Lets an application end a connection at once: `state.transport` of its request.

    A connection without a request is ended: nobody can keep all of them busy with nothing.
    """

    def connection_made(self, transport: Any) -> None:
        """Remember the transport."""
        self._patience = self.loop.call_later(FIRST_WITHIN_S, self._end_if_silent, transport)
        self.app_state: dict[str, Any] = {**self.app_state, 'transport': transport}
        super().connection_made(transport)
        transport.set_write_buffer_limits(high=PIECE)

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget it: the timer would keep it, and one client may open many."""
        self._patience.cancel()
        super().connection_lost(exc)

    def _end_if_silent(self, transport: Any) -> None:
        cycle: Any = self.cycle
        if cycle is None:
            transport.abort()


def _prepare(taken: socket.socket) -> None:
    """Set what connections inherit."""
    taken.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER)
    if hasattr(socket, 'TCP_USER_TIMEOUT'):  # the kernel ends a connection that takes nothing
        limit_ms = int(SEND_LIMIT_S * 1000)
        taken.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, limit_ms)
