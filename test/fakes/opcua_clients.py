"""What clients do at a server without a cell."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import asyncua
from asyncua.common.subscription import Subscription
from fakes.guarded import Bench, becomes


class Heard:
    """What a subscription told."""

    def __init__(self) -> None:
        self.values: list[object] = []

    def datachange_notification(self, node: object, value: object, data: object) -> None:
        """Take note."""
        self.values.append(value)


async def watching(bench: Bench, client: asyncua.Client) -> tuple[Subscription, Heard]:
    """Let a client subscribe, and wait for the first value."""
    heard = Heard()
    subscription = await client.create_subscription(50, heard)
    await subscription.subscribe_data_change(client.get_node(bench.variable.nodeid))
    await becomes(lambda: bool(heard.values))
    return subscription, heard


@asynccontextmanager
async def two(bench: Bench, other: str = 'ann') -> AsyncIterator[tuple[Any, Any, int]]:
    """Connect two users; the first has a subscription."""
    async with bench.plain() as first, bench.plain(other) as second:
        subscription, _ = await watching(bench, first)
        await second.create_subscription(500, Heard())
        yield first, second, subscription.subscription_id


@asynccontextmanager
async def channel(client: asyncua.Client) -> AsyncIterator[None]:
    """Open a connection without a session."""
    await client.connect_socket()
    try:
        await client.send_hello()
        await client.open_secure_channel()
        yield
    finally:
        client.disconnect_socket()
