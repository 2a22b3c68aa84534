"""A wire between browser and page that can be cut, go silent, or lose one event."""

from __future__ import annotations

import asyncio
import contextlib
import json
import re
import socket
import struct
import threading
from collections.abc import Callable, Coroutine
from typing import Any, TypeVar

from patience import PATIENCE_S

Filter = Callable[[bytes], bytes]
"""Gets what the page sends, piece by piece, and returns as many bytes of it."""

_T = TypeVar('_T')
_BUNDLE = re.compile(rb'event: ?happened\r?\n(?:id:.*\r?\n)?data: ?({.*})\r?\n')
_PIECE = 64 * 1024


class Proxy:
    """TCP from `port` to another one of this computer, in a thread of its own. Ends in `close`.

    What a silent wire has been given comes later, as TCP would send it again.
    """

    def __init__(self, target: int) -> None:
        self._target = target
        self._wires: set[asyncio.StreamWriter] = set()
        self._filter: Filter = lambda piece: piece
        self._is_cut = False
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._thread.start()
        self._passing = self._do(_event())
        self._server = self._do(self._listen())
        self.port: int = self._server.sockets[0].getsockname()[1]

    def cut(self) -> None:
        """End every connection at once, and each new one, until `mend`."""
        self._do(self._cut())

    def go_silent(self) -> None:
        """Keep every connection, and each new one, and let nothing pass, until `mend`."""
        self._do(self._set(self._passing.clear))

    def mend(self) -> None:
        """Let everything pass again."""
        self._is_cut = False
        self._do(self._set(self._passing.set))

    def lose(self, lost: Filter) -> None:
        """Send from now on what the filter makes of the page's answers."""
        self._filter = lost

    @property
    def connections(self) -> int:
        """How many there are to the page."""
        return len(self._wires) // 2

    def close(self) -> None:
        """End everything."""
        self._do(self._cut())
        self._do(self._end())
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()

    def _do(self, work: Coroutine[Any, Any, _T]) -> _T:
        return asyncio.run_coroutine_threadsafe(work, self._loop).result(PATIENCE_S)

    async def _listen(self) -> asyncio.Server:
        return await asyncio.start_server(self._connect, '127.0.0.1', 0)

    async def _set(self, change: Callable[[], None]) -> None:
        change()

    async def _cut(self) -> None:
        self._is_cut = True
        for wire in self._wires:
            _reset(wire)

    async def _end(self) -> None:
        self._server.close()
        rest = asyncio.all_tasks() - {asyncio.current_task()}
        for task in rest:
            task.cancel()
        await asyncio.gather(*rest, return_exceptions=True)

    async def _connect(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        if self._is_cut:
            _reset(writer)
            return
        try:
            far_reader, far_writer = await asyncio.open_connection('127.0.0.1', self._target)
        except OSError:  # the page is gone
            _reset(writer)
            return
        self._wires |= {writer, far_writer}
        try:
            await asyncio.gather(
                self._carry(reader, far_writer, lambda piece: piece),
                self._carry(far_reader, writer, self._filtered),
            )
        except asyncio.CancelledError:
            pass  # asyncio's own callback stumbles over a handler that was cancelled
        finally:
            self._wires -= {writer, far_writer}

    def _filtered(self, piece: bytes) -> bytes:
        """Ask the filter of now, for wires that are older."""
        return self._filter(piece)

    async def _carry(
        self, source: asyncio.StreamReader, target: asyncio.StreamWriter, passing: Filter
    ) -> None:
        try:
            while piece := await source.read(_PIECE):
                await self._passing.wait()
                target.write(passing(piece))
                await target.drain()
            await self._passing.wait()
        except OSError:
            pass  # an end has gone, and the other one follows
        finally:
            target.close()


def _reset(wire: asyncio.StreamWriter) -> None:
    """End a connection as a machine does that knows nothing of it."""
    linger = struct.pack('ii', 1, 0)
    with contextlib.suppress(OSError):  # it has just ended by itself
        wire.get_extra_info('socket').setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, linger)
    wire.transport.abort()


async def _event() -> asyncio.Event:
    passing = asyncio.Event()
    passing.set()
    return passing


class LoseOneEvent:
    """Overwrites one event of the stream with blanks, which JSON does not mind.

    :ivar lost: its number, once it is lost
    """

    def __init__(self) -> None:
        self.lost: int | None = None

    def __call__(self, piece: bytes) -> bytes:
        """Return the piece, without the first record of the first whole bundle."""
        bundle = _BUNDLE.search(piece)
        if self.lost is not None or bundle is None:
            return piece
        text = bundle[1].decode()
        start = text.index('[', text.index('"records"')) + 1
        record, end = json.JSONDecoder().raw_decode(text, start)
        self.lost = record['seq']
        end += text[end] == ','
        rest = (text[:start] + ' ' * len(text[start:end].encode()) + text[end:]).encode()
        return piece[: bundle.start(1)] + rest + piece[bundle.end(1) :]
