"""An address space with the nodesets, and without a cell."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Mapping

from fakes.opcua_access import any_security

from bt_orchestrator.extensions.opcua.server import nodesets
from bt_orchestrator.extensions.opcua.server.server import make_stack
from bt_orchestrator.extensions.opcua.server.space import Space


class BareSpace:
    """One for many tests; each makes nodes of its own."""

    def __init__(self) -> None:
        self._loop = asyncio.new_event_loop()
        self._space = self._loop.run_until_complete(self._made())

    def __call__(self, what: Callable[[Space], Awaitable[None]]) -> None:
        """Do something in it."""

        async def done() -> None:
            await what(self._space)

        self._loop.run_until_complete(done())

    @property
    def ns(self) -> Mapping[str, int]:
        """What loading the nodesets has told."""
        return self._space.ns

    def close(self) -> None:
        """End its loop."""
        self._loop.close()

    @staticmethod
    async def _made() -> Space:
        server = await make_stack('/node', any_security('/node'), 'opc.tcp://127.0.0.1:0')
        return await Space.of(server, 'cell', await nodesets.load(server))
