"""Rows of dispatch while others look on, and with the client that uses no inside of rclpy."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import AsyncExitStack, closing, contextmanager
from pathlib import Path
from threading import Event

from opcua_process import OpcUaProcess
from page_process import PageProcess
from stream_readers import StreamReader

from bench.opcua_rows import Mes, logged_in
from bench.rows import Row
from bench.stand import Measured, Ratios, Stand, in_turns, stand
from bench.tail import PATIENCE_S
from bt_orchestrator.ros.node_parameters import SINGLE

ALONE, PLAIN_CLIENT = 'ours FULL', 'ours FULL, client plain'
PAGE, OPCUA = 'ours FULL, page with one reader', 'ours FULL, OPC UA with two subscribers'

SUBSCRIBERS = 2


def attached(rounds: int, cycles: int) -> Iterator[Row]:
    """Drive the line alone, and with each of the others, in turns."""
    with stand() as here:
        results = [_round(here, cycles, number) for number in range(rounds)]
    ratios = Ratios(results)
    yield Row('plain_client', ratios.sequence(PLAIN_CLIENT, ALONE))
    yield Row('plain_client_cpu', ratios.cpu(PLAIN_CLIENT, ALONE))
    yield Row('page_attached', ratios.sequence(PAGE, ALONE))
    yield Row('opcua_attached', ratios.sequence(OPCUA, ALONE))


def _round(here: Stand, cycles: int, number: int) -> dict[str, Measured]:
    def ours(*options: str) -> Callable[[], Measured]:
        return lambda: here.ours(cycles, 'FULL', SINGLE, options=options)

    drives = {
        ALONE: ours(),
        PLAIN_CLIENT: ours('--client', 'plain'),
        PAGE: lambda: here.ours(cycles, 'FULL', SINGLE, attached=lambda: _page(here.folder)),
        OPCUA: lambda: here.ours(
            cycles,
            'FULL',
            SINGLE,
            attached=lambda: _opcua(here),
            options=('--trust-local-doors',),
        ),
    }
    return in_turns(drives, number)


@contextmanager
def _page(folder: Path) -> Iterator[None]:
    """Have the page there, and one reader of its stream."""
    with closing(PageProcess(folder, '/bt_orchestrator')) as page:
        page.wait_heard()
        with closing(StreamReader(page.port)) as reader:
            reader.wait_begun()
            yield


@contextmanager
def _opcua(here: Stand) -> Iterator[None]:
    """Have the OPC UA server there, and clients that subscribe as an MES does."""
    options = ['--insecure', '--trees', str(here.folder)]
    with (
        closing(OpcUaProcess(here.folder, '/bt_orchestrator', options)) as server,
        ThreadPoolExecutor(1) as pool,
    ):
        server.wait_ready()
        have_begun, is_over = Event(), Event()
        clients = pool.submit(
            asyncio.run, _subscribe(server.endpoint, here.script.stem, have_begun, is_over)
        )
        clients.add_done_callback(lambda _: have_begun.set())
        try:
            assert have_begun.wait(PATIENCE_S), 'the clients never subscribed'
            if not clients.done():
                yield
        finally:
            is_over.set()
        clients.result(PATIENCE_S)


async def _subscribe(endpoint: str, script: str, have_begun: Event, is_over: Event) -> None:
    async with AsyncExitStack() as stack:
        for _ in range(SUBSCRIBERS):
            client = await stack.enter_async_context(logged_in(endpoint))
            await Mes(client, script).subscribe()
        have_begun.set()
        await asyncio.to_thread(is_over.wait)
