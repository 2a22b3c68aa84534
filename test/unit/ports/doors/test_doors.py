"""The threads with the doors: what is asked never holds up what is heard."""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest
from fakes.statuses import status
from patience import PATIENCE_S

from bt_orchestrator.base.errors import NodeUnreachable
from bt_orchestrator.model.events import JobHeld
from bt_orchestrator.model.status import CellStatus
from bt_orchestrator.ports import CellLink, EventPage, Listener
from bt_orchestrator.ports.doors import following_door
from bt_orchestrator.ports.doors.doors import AskingDoor, Doors
from bt_orchestrator.ports.doors.following_door import DEAF_S, Began, Fact, FollowingDoor, Happened


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
        asking = AskingDoor('page', door.open, asyncio.get_running_loop())
        asking.start()
        try:
            await asyncio.wait_for(work(door, asking), PATIENCE_S)
        finally:
            asking.end()
            await asyncio.to_thread(asking.join)

    asyncio.run(whole())
    return door


def test_door_opens_on_first_question_closes_at_end() -> None:
    async def work(door: Door, asking: AskingDoor) -> None:
        assert door.opened == 0
        assert await asking.call(door.quick('one')) == 'one'
        assert await asking.call(door.quick('two')) == 'two'

    door = with_asking(work)
    assert (door.opened, door.closed) == (1, 1)


def test_loop_continues_while_node_does_not_answer() -> None:
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


def test_questions_are_refused_while_page_ends() -> None:
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
    assert [str(error) for error in refused] == ['the page ends', 'the page ends']


def test_silent_node_refuses_reads_but_gets_commands() -> None:
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


def test_deaf_door_is_reopened_without_losing_events() -> None:
    links = [DeafLink(), DeafLink()]
    opened = iter(links)
    left: list[object] = []
    facts: list[Fact] = []

    @contextmanager
    def open_door(meanwhile: Callable[[], object]) -> Iterator[Any]:
        yield next(opened)

    door = FollowingDoor('page', open_door, facts.extend)
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
    assert [fact for fact in facts if isinstance(fact, Began)] == [Began('a', 5)]


def test_deaf_door_is_replaced_for_next_question() -> None:
    async def work(door: Door, asking: AskingDoor) -> None:
        assert await asking.call(door.quick('one')) == 'one'
        asking.renew()
        assert await asking.call(door.quick('two')) == 'two'
        assert await asking.call(door.quick('three')) == 'three'

    door = with_asking(work)
    assert (door.opened, door.closed) == (2, 2)


class TellingDoor:
    """A door at which events come, and which may say that it cannot tell them."""

    def __init__(self, last: int, *comes: int | None) -> None:
        """Prepare.

        :param comes: numbers of events, one a turn; None: it cannot tell them
        """
        self.last = last
        self.comes = list(comes)
        self.followed_from: tuple[int | None, str] | None = None
        self.silent_s = 0.25

    def status(self) -> CellStatus:
        return replace(status(), seq=self.last, history='one')

    def events_after(self, seq: int, most: int = 0) -> EventPage:
        return EventPage('one', (), 1, self.last)

    def follow(self, listener: Listener, after_seq: int | None = None, history: str = '') -> None:
        self.followed_from = (after_seq, history)
        self._listener = listener

    def turn(self, within_s: float) -> None:
        if not self.comes:
            time.sleep(0.001)  # as a door waits
            return
        seq = self.comes.pop(0)
        if seq is None:
            raise NodeUnreachable('the journal cannot be read')
        self._listener.on_event(JobHeld(seq=seq, job='J'))


class Follow:
    """A following door at some doors, one after the other."""

    def __init__(self, *doors: TellingDoor) -> None:
        self._doors = list(doors)
        self.facts: list[Fact] = []
        self.following = FollowingDoor('page', self._open, self.facts.extend)

    @contextmanager
    def _open(self, meanwhile: Callable[[], object]) -> Iterator[Any]:
        yield self._doors.pop(0)

    @property
    def told(self) -> list[int]:
        return [fact.event.seq for fact in self.facts if isinstance(fact, Happened)]

    def until(self, condition: Callable[[], object]) -> None:
        deadline = time.monotonic() + PATIENCE_S
        while not condition():
            assert time.monotonic() < deadline
            time.sleep(0.001)

    def __enter__(self) -> Follow:
        self.following.start()
        return self

    def __exit__(self, *exception: object) -> None:
        self.following.end()
        self.following.join()


class TestFollowing:
    def test_it_begins_with_what_happens_from_now_on(self) -> None:
        door = TellingDoor(7, 8, 9)
        with Follow(door) as follow:
            follow.until(lambda: follow.told == [8, 9])
        assert follow.facts[0] == Began('one', 7)
        assert door.followed_from == (7, 'one')

    def test_nothing_heard_is_silence(self) -> None:
        follow = Follow(TellingDoor(7))
        assert 0 <= follow.following.silent_s < PATIENCE_S
        with follow:
            follow.until(lambda: follow.following.silent_s == 0.25)

    def test_next_door_continues_after_failure_without_repeats(
        self, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr(following_door, 'AGAIN_S', 0.01)
        first, second = TellingDoor(7, 8, None), TellingDoor(9, 9)
        with Follow(first, second) as follow:
            follow.until(lambda: follow.told == [8, 9])
        assert second.followed_from == (8, 'one')
        assert [fact for fact in follow.facts if isinstance(fact, Began)] == [Began('one', 7)]

    def test_node_that_cannot_send_events_counts_as_silent(
        self, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr(following_door, 'AGAIN_S', 0.01)
        monkeypatch.setattr(following_door, 'STEADY_S', 0.2)
        with Follow(TellingDoor(7, 8, None), TellingDoor(9, 9)) as follow:
            follow.until(lambda: follow.told == [8, 9])
            assert follow.following.silent_s != 0.25
            follow.until(lambda: follow.following.silent_s == 0.25)
