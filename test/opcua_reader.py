"""asyncua's own client, which reads and calls by the paths of nodes."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable, Coroutine
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import asyncua
from asyncua import ua
from patience import PATIENCE_S


class Reader:
    """Reads a cell by the paths of its nodes."""

    def __init__(self, client: asyncua.Client, idx: int) -> None:
        self.client = client
        self.idx = idx

    @classmethod
    async def of(cls, client: asyncua.Client) -> Reader:
        """Look up the cell that the server shows."""
        for index, uri in enumerate(await client.get_namespace_array()):
            if uri.startswith('urn:bt_orchestrator:cell:'):
                return cls(client, index)
        raise AssertionError('no cell')

    def node(self, path: str) -> asyncua.Node:
        """Return a node of the cell."""
        return self.client.get_node(ua.NodeId(path, self.idx))

    async def value(self, path: str) -> Any:
        """Read a variable."""
        return await self.node(path).read_value()

    async def wait(self, path: str, is_so: Callable[[Any], object]) -> Any:
        """Wait until a variable is as expected; returns its value."""
        deadline = time.monotonic() + PATIENCE_S
        while not is_so(value := await self.value(path)):
            assert time.monotonic() < deadline, f'{path} is {value!r}'
            await asyncio.sleep(0.05)
        return value

    async def call(self, path: str, *arguments: object) -> Any:
        """Call a method; returns its outputs."""
        above, _, _ = path.rpartition('/')
        return await self.node(above).call_method(self.node(path).nodeid, *arguments)


def client_of(url: str) -> asyncua.Client:
    """Return a client that is as patient as a test.

    asyncua's own takes a server for dead that has not answered for a second.
    """
    return asyncua.Client(url, timeout=PATIENCE_S, watchdog_intervall=PATIENCE_S)


def reading(url: str, what: Callable[[Reader], Awaitable[object]]) -> None:
    """Do something with a client, without encryption and login."""

    async def connected() -> None:
        async with client_of(url) as client:
            await what(await Reader.of(client))

    to_the_end(connected())


def to_the_end(work: Coroutine[Any, Any, None]) -> None:
    """Do it in a thread of its own: the driver of a browser has a loop in the one of the tests."""
    with ThreadPoolExecutor(1) as pool:
        pool.submit(asyncio.run, work).result()
