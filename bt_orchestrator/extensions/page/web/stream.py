"""The stream of server-sent events: what happens, to everybody who looks.

A stream of an allowed reader is always answered with 200: a browser gives up for good on anything
else. While nothing was heard of the cell there are comments and beats.
"""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import AsyncIterator, Callable, Iterator, Mapping
from typing import Any

from starlette.requests import Request
from starlette.types import Receive, Scope, Send

from bt_orchestrator.base.errors import NodeUnreachable
from bt_orchestrator.extensions.page.web import messages
from bt_orchestrator.extensions.page.web.board import MOST_IN_ONE, Board, Cursor
from bt_orchestrator.ports import EventPage
from bt_orchestrator.ports.doors.doors import Doors
from bt_orchestrator.ports.doors.following_door import Happened, Lost

MOST_READERS = 64

SEND_LIMIT_S = 10.0
"""A reader that takes nothing for so long is sent away."""

BEAT_S = 1.0

PIECE = 16 * 1024
"""Bytes that are written at once: one connection buffers about twice as much in this process."""

HEADERS = [
    (b'content-type', b'text/event-stream; charset=utf-8'),
    (b'cache-control', b'no-store'),
    (b'x-accel-buffering', b'no'),
]


class Reader:
    """One open stream."""

    def __init__(self, wanted: str, send: Send, state: Mapping[str, Any]) -> None:
        self.history, self.seq = _place(wanted)
        """Its position; None: it is new."""
        self.cursor: Cursor | None = None
        """None: it has not begun."""
        self.is_over = False
        self.is_beat_due = False
        self.fetch: asyncio.Task[EventPage | None] | None = None
        """Of older events than the board has, while it is behind."""
        self.wake = asyncio.Event()
        self._send = send
        self.may_look: Callable[[], bool] = state.get('may_look', lambda: True)
        self._transport: asyncio.Transport | None = state.get('transport')
        self._sending_since: float | None = None

    def look(self) -> None:
        """Do what there is to do now."""
        self.wake.set()

    async def send(self, text: bytes) -> None:
        """Send a message; returns when there is room for more."""
        for begin in range(0, len(text), PIECE):
            piece = text[begin : begin + PIECE]
            self._sending_since = time.monotonic()
            await self._send({'type': 'http.response.body', 'body': piece, 'more_body': True})
        self._sending_since = None

    def is_stuck(self, limit_s: float) -> bool:
        """Tell whether it has taken nothing for so long."""
        since = self._sending_since
        return since is not None and time.monotonic() - since >= limit_s

    def cut(self) -> None:
        """End its connection at once, and forget what is still to be sent."""
        self.is_over = True
        if self._transport is not None:
            self._transport.abort()
        self.look()


class Streams:
    """All open streams. An ASGI application: each request is one of them."""

    def __init__(self, board: Board, doors: Doors, refresh: Callable[[], object]) -> None:
        """Begin without readers.

        :param refresh: brings the parts of the board up to date; called for a new reader
        """
        self._board = board
        self._doors = doors
        self._refresh = refresh
        self._is_ending = False
        self._beat = b''
        self._fetches: dict[tuple[str, int], asyncio.Task[EventPage | None]] = {}
        self.readers: set[Reader] = set()

    def wake(self) -> None:
        """Tell all readers that there is something new."""
        for reader in self.readers:
            reader.look()

    def beat(self) -> None:
        """Tell all readers that the page is alive.

        Send away who takes nothing, or may not look any more.
        """
        if not self.readers:
            return
        now, silent_s = time.time(), self._doors.silent_s
        self._beat = messages.message('beat', silent_s=round(silent_s, 1), now=round(now, 3))
        for reader in list(self.readers):
            reader.is_beat_due = True
            reader.look()
            if reader.is_stuck(SEND_LIMIT_S) or not reader.may_look():
                reader.cut()
        cursors = [reader.cursor.version for reader in self.readers if reader.cursor]
        self._board.forget_gone(min(cursors, default=self._board.version))

    def end(self) -> None:
        """End all streams, at once."""
        self._is_ending = True
        for reader in list(self.readers):
            if reader.is_stuck(0.0):
                reader.cut()
            reader.look()

    # --- one stream -------------------------------------------------------------------------

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Carry out one request for the stream."""
        request = Request(scope)
        wanted = request.headers.get('last-event-id') or request.query_params.get('after', '')
        reader = Reader(wanted, send, scope.get('state', {}))
        await send({'type': 'http.response.start', 'status': 200, 'headers': HEADERS})
        if len(self.readers) >= MOST_READERS:
            await reader.send(messages.FULL)
        else:
            await self._serve(reader, receive)
        await send({'type': 'http.response.body', 'body': b'', 'more_body': False})

    async def _serve(self, reader: Reader, receive: Receive) -> None:
        self.readers.add(reader)
        leaving = asyncio.create_task(_leave(reader, receive))
        try:
            self._refresh()
            await reader.send(messages.WAITING)  # the headers leave with the first bytes
            while not (reader.is_over or self._is_ending):
                reader.wake.clear()
                async for text in self._due(reader):
                    await reader.send(text)
                await reader.wake.wait()
        finally:
            self.readers.discard(reader)
            leaving.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await leaving

    async def _due(self, reader: Reader) -> AsyncIterator[bytes]:
        """Yield what a reader has to get now, and move its cursor on."""
        if self._board.status is not None:
            begun = self._begin(reader)
            if begun is not None:
                yield begun
            async for text in self._older(reader):
                yield text
            for text in self._news(reader):
                yield text
        if reader.is_beat_due:
            reader.is_beat_due = False
            if self._board.status is None:
                yield messages.WAITING
            yield self._beat

    def _begin(self, reader: Reader) -> bytes | None:
        """Let a reader begin, or begin anew with another history."""
        board, cursor = self._board, reader.cursor
        if cursor is not None and cursor.history == board.history:
            return None
        cursor = reader.cursor = board.start(reader.history, reader.seq)
        reader.seq = None
        return messages.begin(
            cursor.history,
            cursor.seq,
            version=board.version,
            now=round(time.time(), 3),
            node=self._doors.name,
            silent_s=round(self._doors.silent_s, 1),
        )

    def _news(self, reader: Reader) -> Iterator[bytes]:
        cursor = reader.cursor
        assert cursor is not None
        if (text := self._board.next_parts(cursor)) is not None:
            yield text
        while not self._board.is_behind(cursor):
            if (text := self._board.next_events(cursor)) is None:
                break
            yield text

    # --- older events than the board has -----------------------------------------------------

    async def _older(self, reader: Reader) -> AsyncIterator[bytes]:
        """Yield what was fetched for a reader that was away for long."""
        cursor = reader.cursor
        assert cursor is not None
        while self._board.is_behind(cursor) and not (reader.is_over or self._is_ending):
            if reader.fetch is None:
                reader.fetch = self._fetch(cursor, reader.look)
            if not reader.fetch.done():
                return  # it wakes the reader
            page, reader.fetch = reader.fetch.result(), None
            if page is None or page.history != cursor.history:
                return  # tried again with the next beat
            pieces = list(_pieces(page, cursor.seq, self._board.ring.before))
            if not pieces:
                return
            for piece in pieces:
                cursor.seq = piece.last if isinstance(piece, Lost) else piece[-1].last
                yield self._board.told(piece)

    def _fetch(self, cursor: Cursor, wake: Callable[[], object]) -> asyncio.Task[EventPage | None]:
        """Return the fetch of what comes after a cursor; readers at one place share it."""
        key = (cursor.history, cursor.seq)
        fetch = self._fetches.get(key)
        if fetch is None:
            fetch = self._fetches[key] = asyncio.create_task(self._fetched(*key))
            fetch.add_done_callback(lambda _: self._fetches.pop(key))
        fetch.add_done_callback(lambda _: wake())
        return fetch

    async def _fetched(self, history: str, seq: int) -> EventPage | None:
        try:
            page = await self._doors.events_after(seq)
        except NodeUnreachable:
            return None
        return page if page.history == history else None


def _pieces(page: EventPage, after: int, last: int) -> Iterator[Lost | list[Happened]]:
    """Yield fetched events in pieces of one message, up to a last one."""
    events = [event for event in page.events if after < event.seq <= last]
    first = events[0].seq if events else min(page.first_seq, last + 1)
    if first > after + 1:
        yield Lost(after + 1, first - 1)
    for begin in range(0, len(events), MOST_IN_ONE):
        yield [Happened(event) for event in events[begin : begin + MOST_IN_ONE]]


async def _leave(reader: Reader, receive: Receive) -> None:
    """Note that a reader has left."""
    message: Any = {}
    while message.get('type') != 'http.disconnect':
        message = await receive()
    reader.is_over = True
    reader.look()


def _place(wanted: str) -> tuple[str, int | None]:
    """Read HISTORY:SEQ; None: it is no place in a history."""
    history, _, seq = wanted.rpartition(':')
    is_number = seq.isascii() and seq.isdecimal() and len(seq) < 20
    return (history, int(seq)) if history and is_number else ('', None)
