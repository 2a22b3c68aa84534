"""Connections. Each test is of an override of asyncua, and fails without it."""

from __future__ import annotations

import asyncio
import struct

import pytest
from asyncua import ua
from fakes.guarded import SOON_S, Bench, Served, becomes
from fakes.opcua_clients import channel

from bt_orchestrator.extensions.opcua.server.overrides import limits

HELLO = struct.pack('<3sc6I', b'HEL', b'F', 32, 0, 65535, 65535, 0, 0) + b'\xff\xff\xff\xff'
HELLO = HELLO[:4] + struct.pack('<I', len(HELLO)) + HELLO[8:]


async def sent(bench: Bench, *parts: bytes) -> bytes:
    """Send bytes; returns what comes until the server closes the connection."""
    reader, writer = await asyncio.open_connection('127.0.0.1', bench.server.bserver.port)
    try:
        for part in parts:
            writer.write(part)
        return await asyncio.wait_for(reader.read(), SOON_S)
    except ConnectionError:
        return b''
    finally:
        writer.close()


@pytest.mark.parametrize(
    'parts',
    [
        (b'HELF' + struct.pack('<I', 2**31), b'x' * 1000),
        (HELLO, b'OPNF' + struct.pack('<II', 2**31, 0), b'x' * 1000),
        (HELLO, b'MSGF' + struct.pack('<I', 4)),
        (HELLO, HELLO),
        (HELLO[:12] + struct.pack('<II', 1, 1) + HELLO[20:],),
        (HELLO, b'OPNF' + struct.pack('<III', 100, 0, 2**31 - 1) + b'x' * 88),
        (HELLO, b'MSGF' + struct.pack('<IIII', 24, 0, 77, 1) + b'x' * 4),
        (HELLO, b'XYZF' + struct.pack('<I', 20) + b'x' * 12),
        (b'GET / HTTP/1.1\r\n\r\n',),
        (b'OPNF' + struct.pack('<III', 32, 0, 0) + b'x' * 20,),
    ],
)
def test_what_cannot_be_read_ends_its_connection(secure: Served, parts: tuple[bytes, ...]) -> None:
    async def work(bench: Bench) -> None:
        await sent(bench, *parts)
        await becomes(lambda: not bench.server.bserver.clients)

    secure(work)


def test_a_long_message_needs_a_login_first(secure: Served) -> None:
    async def work(bench: Bench) -> None:
        client = bench.plain()
        async with channel(client):
            long = ua.GetEndpointsParameters(EndpointUrl='x' * 300_000)
            with pytest.raises((ua.UaError, ConnectionError, asyncio.TimeoutError)):
                await client.uaclient.get_endpoints(long)

    secure(work)


def test_many_connections_without_a_login_keep_nobody_out(
    secure: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(limits, 'PENDING', 3)

    async def work(bench: Bench) -> None:
        port = bench.server.bserver.port
        held = [await asyncio.open_connection('127.0.0.1', port) for _ in range(10)]
        await becomes(lambda: len(bench.server.bserver.clients) == 3)
        (first, *_) = await bench.plain().connect_and_get_server_endpoints()
        assert first.Server.ApplicationUri == bench.security.own.uri
        for _, writer in held:
            writer.close()

    secure(work)


def test_answers_that_nobody_reads_do_not_pile_up(
    insecure: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(limits, 'UNREAD_BYTES', 100_000)

    async def work(bench: Bench) -> None:
        async with bench.plain() as client:
            client.uaclient.protocol.transport.pause_reading()
            browse = ua.BrowseDescription(ua.NodeId(ua.ObjectIds.Server))
            params = ua.BrowseParameters(NodesToBrowse=[browse] * limits.BROWSED)
            asked = [
                asyncio.ensure_future(client.uaclient.session.browse(params)) for _ in range(60)
            ]
            await becomes(lambda: not bench.server.bserver.clients)
            client.uaclient.protocol.transport.abort()  # or it would wait for an answer
            for request in asked:
                request.cancel()
            await asyncio.gather(*asked, return_exceptions=True)

    insecure(work)
