"""Streams whose readers need older events than the board has; the fetch may take its time."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Awaitable, Callable
from dataclasses import replace
from typing import Any, cast

from fakes.statuses import status
from patience import PATIENCE_S

from bt_orchestrator.extensions.page.web.board import Board
from bt_orchestrator.extensions.page.web.stream import Streams
from bt_orchestrator.model.events import JobHeld
from bt_orchestrator.ports import EventPage
from bt_orchestrator.ports.doors.following_door import Happened


class SlowDoors:
    """Fetches an event a page, when it is let."""

    name = '/node'
    silent_s = 0.0

    def __init__(self) -> None:
        self.may_answer = asyncio.Event()
        self.asked: list[int] = []

    async def events_after(self, seq: int, most: int = 0) -> EventPage:
        self.asked.append(seq)
        await self.may_answer.wait()
        return EventPage('one', (JobHeld(seq=seq + 1, job='J'),), 1, 9)


class Scene:
    """A board that begins after event 9, and streams of it."""

    def __init__(self) -> None:
        self.board = Board()
        self.begin('one', 9)
        self.doors = SlowDoors()
        self.streams = Streams(self.board, cast('Any', self.doors), lambda: None)

    def begin(self, history: str, last: int) -> None:
        self.board.begin(history, last)
        self.board.status = replace(status(), seq=last, history=history)


class Reader:
    """One request for the stream, which notes what it gets."""

    def __init__(self, scene: Scene, after: str) -> None:
        self.got: list[tuple[str, dict[str, Any]]] = []
        self._left = asyncio.Event()
        scope = {'type': 'http', 'headers': [(b'last-event-id', after.encode())]}
        self._task = asyncio.create_task(scene.streams(scope, self._receive, self._send))

    async def _receive(self) -> dict[str, Any]:
        await self._left.wait()
        return {'type': 'http.disconnect'}

    async def _send(self, message: Any) -> None:
        for text in message.get('body', b'').decode().split('\n\n'):
            fields = dict(line.split(': ', 1) for line in text.splitlines())
            if 'event' in fields:
                self.got.append((fields['event'], json.loads(fields['data'])))

    async def leave(self) -> None:
        self._left.set()
        await self._task

    async def until(self, condition: Callable[[], object]) -> None:
        async def wait() -> None:
            while not condition():
                await asyncio.sleep(0.001)

        await asyncio.wait_for(wait(), PATIENCE_S)

    async def until_told(self, *seqs: int) -> None:
        await self.until(lambda: self.seqs == [*seqs])

    @property
    def seqs(self) -> list[int]:
        messages = [data for kind, data in self.got if kind == 'happened']
        return [record['seq'] for data in messages for record in data['records']]


def run(work: Callable[[Scene], Awaitable[None]]) -> None:
    async def whole() -> None:
        await work(Scene())

    asyncio.run(whole())


def test_readers_at_one_place_share_a_fetch() -> None:
    async def work(scene: Scene) -> None:
        readers = [Reader(scene, 'one:6') for _ in range(3)]
        await readers[0].until(lambda: scene.doors.asked)
        scene.doors.may_answer.set()
        for reader in readers:
            await reader.until_told(7, 8, 9)
            await reader.leave()
        assert scene.doors.asked == [6, 7, 8]

    run(work)


def test_who_leaves_during_a_fetch_leaves_nothing_behind() -> None:
    async def work(scene: Scene) -> None:
        reader = Reader(scene, 'one:6')
        await reader.until(lambda: scene.doors.asked)
        await reader.leave()
        scene.doors.may_answer.set()
        await reader.until(lambda: not scene.streams._fetches)
        assert scene.doors.asked == [6]

    run(work)


def test_events_fetched_from_old_history_are_dropped() -> None:
    async def work(scene: Scene) -> None:
        reader = Reader(scene, 'one:6')
        await reader.until(lambda: scene.doors.asked)
        scene.begin('two', 8)
        scene.streams.wake()
        await reader.until(lambda: ('begin', 8) in [(k, d.get('after')) for k, d in reader.got])
        scene.doors.may_answer.set()
        await reader.until(lambda: not scene.streams._fetches)
        scene.board.ring.add(Happened(JobHeld(seq=9, job='K')))
        scene.streams.wake()
        await reader.until(lambda: reader.seqs)
        assert reader.seqs == [9]
        await reader.leave()

    run(work)
