"""Whatever is lost between a node and its client, the client gets every event once, in order."""

from __future__ import annotations

from collections.abc import Callable
from random import Random
from types import SimpleNamespace
from typing import Any

import pytest

from bt_orchestrator.ros.event_follower import EventFollower

PAGE = 3


class LossyNode:
    """A node whose topic loses what one says; its journal loses nothing but what was removed."""

    def __init__(self) -> None:
        self.first = 1
        self.journal: list[Any] = []
        self.asked = 0

    def happen(self, *lost: bool, event: str = 'task.started') -> None:
        """Let events happen; those that are lost do not come on the topic."""
        for is_lost in lost:
            message = SimpleNamespace(seq=len(self.journal) + 1, event=event)
            self.journal.append(message)
            if not is_lost:
                self._event(message)

    def tell_status(self) -> None:
        self._status(self.status())

    def forget(self) -> None:
        """Start again without a journal."""
        self.journal = []

    def on_event(self, callback: Callable[[Any], None]) -> None:
        self._event = callback

    def on_status(self, callback: Callable[[Any], None]) -> None:
        self._status = callback

    def status(self) -> Any:
        return SimpleNamespace(seq=len(self.journal))

    def events_after(self, seq: int) -> Any:
        self.asked += 1
        after = max(seq, self.first - 1)
        return SimpleNamespace(first_seq=self.first, events=self.journal[after : after + PAGE])


def new(follower: EventFollower) -> list[int]:
    return [message.seq for message in follower.take()]


@pytest.fixture
def node() -> LossyNode:
    found = LossyNode()
    found.on_event(lambda _: None)
    found.on_status(lambda _: None)
    found.happen(*[False] * 5)
    return found


def test_from_now_on(node: LossyNode) -> None:
    follower = EventFollower(node, None)
    node.happen(False, False)
    assert new(follower) == [6, 7]
    assert node.asked == 0


def test_from_a_number_on(node: LossyNode) -> None:
    follower = EventFollower(node, 1)
    node.happen(False)
    assert new(follower) == [2, 3, 4, 5, 6]
    assert new(follower) == []


def test_a_number_that_jumps_is_a_gap(node: LossyNode) -> None:
    follower = EventFollower(node, None)
    node.happen(False, True, True, False)
    assert new(follower) == [6, 7, 8, 9]


def test_a_status_that_is_further_on_is_a_gap(node: LossyNode) -> None:
    follower = EventFollower(node, None)
    node.happen(True, True)
    assert new(follower) == []
    node.tell_status()
    assert new(follower) == [6, 7]


def test_what_was_removed_is_said(node: LossyNode) -> None:
    removed: list[tuple[int, int]] = []
    follower = EventFollower(node, 0, lambda first, last: removed.append((first, last)))
    node.first = 3
    node.tell_status()
    assert new(follower) == [3, 4, 5]
    assert removed == [(1, 2)]


def test_a_node_that_forgot_everything_is_followed_from_its_beginning(node: LossyNode) -> None:
    follower = EventFollower(node, None)
    node.forget()
    node.happen(False, event='orchestrator.started')
    node.happen(False)
    assert new(follower) == [1, 2]


@pytest.mark.parametrize('seed', range(20))
def test_whatever_is_lost(node: LossyNode, seed: int) -> None:
    random = Random(seed)
    follower = EventFollower(node, 0)
    found = []
    for _ in range(30):
        node.happen(*(random.random() < 0.5 for _ in range(random.randint(0, 5))))
        if random.random() < 0.3:
            node.tell_status()
        found += new(follower)
    node.tell_status()
    assert found + new(follower) == list(range(1, len(node.journal) + 1))
