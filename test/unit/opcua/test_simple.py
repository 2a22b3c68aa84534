"""The flat part, as asyncua's own client sees it: a server before a cell in virtual time."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable
from pathlib import Path

import asyncua
from asyncua import ua
from opcua_stand import PATIENCE_S, opcua_stand

from bt_orchestrator.model.jobs.order import WorkOrder


class Reader:
    """Reads a cell by the paths of its nodes."""

    def __init__(self, client: asyncua.Client, idx: int) -> None:
        self.client = client
        self.idx = idx

    @classmethod
    async def of(cls, client: asyncua.Client) -> Reader:
        (uri,) = (
            one
            for one in await client.get_namespace_array()
            if one.startswith('urn:bt_orchestrator:cell:')
        )
        return cls(client, await client.get_namespace_index(uri))

    def node(self, path: str) -> asyncua.Node:
        return self.client.get_node(ua.NodeId(path, self.idx))

    async def value(self, path: str) -> object:
        return await self.node(path).read_value()

    async def wait(self, path: str, is_so: Callable[[object], bool]) -> object:
        deadline = time.monotonic() + PATIENCE_S
        while not is_so(value := await self.value(path)):
            assert time.monotonic() < deadline, f'{path} is {value!r}'
            await asyncio.sleep(0.05)
        return value


def with_reader(url: str, what: Callable[[Reader], Awaitable[None]]) -> None:
    async def connected() -> None:
        async with asyncua.Client(url) as client:
            await what(await Reader.of(client))

    asyncio.run(connected())


def test_a_job_is_seen_from_the_queue_to_its_end(tmp_path: Path) -> None:
    with opcua_stand(tmp_path) as (stand, server):

        async def look(reader: Reader) -> None:
            assert await reader.value('Simple/Connected') is True
            assert await reader.value('Simple/CurrentJob/ID') == ''
            assert stand.queue(WorkOrder(stand.script, 'WO-1', 2)).accepted
            await reader.wait('Simple/CurrentJob/ID', lambda one: one == 'WO-1')
            assert await reader.value('Simple/CurrentJob/Planned') == 2
            await reader.wait('Simple/LastJob/Good', lambda one: one == 2)
            assert await reader.value('Simple/LastJob/State') == 'Ended'

        with_reader(server.address, look)
