"""The threads with the doors: what is asked never holds up what is heard."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from types import SimpleNamespace
from typing import Any

import pytest

from bt_orchestrator.errors import NodeUnreachable
from bt_orchestrator.ports import CellLink, EventPage
from bt_orchestrator.web.door_thread import DEAF_S, AskingDoor, Began, Doors, Fact, FollowingDoor

PATIENCE_S = 20.0


class Door:
    """Answers with what it is told to."""

    def __init__(self) -> None:
        self.opened = 0
        self.closed = 0
        self.go_on = threading.Event()
        self.asked: list[str] = []

    @contextmanager
    def open(self, meanwhile: Callable[[], object]) -> Iterator[Any]:
        self.opened += 1
        self.meanwhile = meanwhile
        yield self
        self.closed += 1

    def slow(self, _: CellLink) -> str:
        """Wait for the node as a real door does."""
        self.asked.append('slow')
        while not self.go_on.wait(0.01):
            self.meanwhile()
        return 'slow'

    def quick(self, word: str) -> Callable[[CellLink], str]:
        def question(_: CellLink) -> str:
            self.asked.append(word)
            return word

        return question


class Heard:
    """A following door, as far as it is asked how long the node has been silent."""

    silent_s = 0.0


def with_asking(work: Callable[[Door, AskingDoor], Awaitable[None]]) -> Door:
    """Do something with a door that asks, and end it."""
    door = Door()

    async def whole() -> None:
        asking = AskingDoor(door.open, asyncio.get_running_loop())
        asking.start()
        try:
            await asyncio.wait_for(work(door, asking), PATIENCE_S)
        finally:
            asking.end()
            await asyncio.to_thread(asking.join)

    asyncio.run(whole())
    return door


def test_it_is_opened_with_the_first_question_and_closed_at_the_end() -> None:
    async def work(door: Door, asking: AskingDoor) -> None:
        assert door.opened == 0
        assert await asking.call(door.quick('one')) == 'one'
        assert await asking.call(door.quick('two')) == 'two'

    door = with_asking(work)
    assert (door.opened, door.closed) == (1, 1)


def test_the_loop_goes_on_while_the_node_does_not_answer() -> None:
    async def work(door: Door, asking: AskingDoor) -> None:
        answer = asyncio.ensure_future(asking.call(door.slow))
        for _ in range(20):
            await asyncio.sleep(0)
        assert not answer.done()
        door.go_on.set()
        assert await answer == 'slow'

    with_asking(work)


def test_commands_are_asked_first() -> None:
    async def work(door: Door, asking: AskingDoor) -> None:
        first = asyncio.ensure_future(asking.call(door.slow))
        while not door.asked:
            await asyncio.sleep(0.001)
        calls = [asyncio.ensure_future(asking.call(door.quick(word))) for word in ('a', 'b')]
        command = asyncio.ensure_future(asking.call(door.quick('abort'), AskingDoor.COMMAND))
        await asyncio.sleep(0)
        door.go_on.set()
        await asyncio.gather(first, command, *calls)

    assert with_asking(work).asked == ['slow', 'abort', 'a', 'b']


def test_an_error_is_told_to_who_asked() -> None:
    async def work(door: Door, asking: AskingDoor) -> None:
        def wrong(_: CellLink) -> str:
            raise NodeUnreachable('it is not there')

        with pytest.raises(NodeUnreachable, match='it is not there'):
            await asking.call(wrong)
        assert await asking.call(door.quick('next')) == 'next'

    with_asking(work)


def test_who_has_left_is_not_asked_for() -> None:
    async def work(door: Door, asking: AskingDoor) -> None:
        first = asyncio.ensure_future(asking.call(door.slow))
        while not door.asked:
            await asyncio.sleep(0.001)
        gone = asyncio.ensure_future(asking.call(door.quick('gone')))
        await asyncio.sleep(0)
        gone.cancel()
        door.go_on.set()
        await first
        await asking.call(door.quick('last'))

    assert with_asking(work).asked == ['slow', 'last']


def test_what_is_asked_while_the_page_ends_is_refused() -> None:
    refused: list[BaseException | str] = []

    async def work(door: Door, asking: AskingDoor) -> None:
        calls = [asking.call(door.slow), asking.call(door.quick('late'))]
        waiting = asyncio.gather(*calls, return_exceptions=True)
        while not door.asked:
            await asyncio.sleep(0.001)
        asking.end()
        refused.extend(await waiting)
        with pytest.raises(NodeUnreachable, match='the page ends'):
            await asking.call(door.quick('too late'))

    with_asking(work)
    assert [str(one) for one in refused] == ['the page ends', 'the page ends']


def test_reading_is_refused_at_once_while_the_node_is_silent_but_a_command_is_sent() -> None:
    async def work(door: Door, asking: AskingDoor) -> None:
        following: Any = Heard()
        following.silent_s = 4.0
        doors = Doors('/node', following, asking)
        with pytest.raises(NodeUnreachable, match='/node has been silent for 4 s'):
            await doors.read(door.quick('look'))
        assert await asking.call(door.quick('abort'), AskingDoor.COMMAND) == 'abort'

    assert with_asking(work).asked == ['abort']


class DeafLink:
    """A door to a node that is heard until it is not; notes from where it is followed."""

    def __init__(self) -> None:
        self.silent_s = 0.0
        self.followed: list[tuple[int, str]] = []
        self.turned = threading.Event()

    def status(self) -> Any:
        return SimpleNamespace(seq=4)

    def events_after(self, seq: int, most: int) -> EventPage:
        return EventPage('a', (), 1, 5)

    def follow(self, listener: FollowingDoor, after_seq: int, history: str) -> None:
        self.followed.append((after_seq, history))
        listener.on_gap(after_seq + 1, after_seq + 2)

    def turn(self, within_s: float) -> None:
        self.turned.set()
        threading.Event().wait(0.001)  # as a door that waits for messages


def test_a_door_that_has_gone_deaf_is_opened_anew_and_misses_nothing() -> None:
    links = [DeafLink(), DeafLink()]
    opened = iter(links)
    left: list[object] = []
    facts: list[Fact] = []

    @contextmanager
    def open_door(meanwhile: Callable[[], object]) -> Iterator[Any]:
        yield next(opened)

    door = FollowingDoor(open_door, facts.extend)
    door.on_deaf = left.append
    door.start()
    assert links[0].turned.wait(PATIENCE_S)
    links[0].silent_s = DEAF_S
    assert links[1].turned.wait(PATIENCE_S)
    door.end()
    door.join()
    assert door.error is None
    assert left == [links[0]]
    assert [link.followed for link in links] == [[(5, 'a')], [(7, 'a')]]
    assert [one for one in facts if isinstance(one, Began)] == [Began('a', 5)]


def test_the_next_question_goes_through_another_door_if_this_one_is_deaf() -> None:
    async def work(door: Door, asking: AskingDoor) -> None:
        assert await asking.call(door.quick('one')) == 'one'
        asking.renew()
        assert await asking.call(door.quick('two')) == 'two'
        assert await asking.call(door.quick('three')) == 'three'

    door = with_asking(work)
    assert (door.opened, door.closed) == (2, 2)
