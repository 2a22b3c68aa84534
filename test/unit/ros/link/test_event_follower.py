"""Whatever is lost between a node and its client, the client gets every event once, in order."""

from __future__ import annotations

from collections.abc import Callable
from random import Random
from types import SimpleNamespace
from typing import Any

import pytest
from fakes import statuses

from bt_orchestrator.model.status import CellStatus
from bt_orchestrator.ros.link.event_follower import EventFollower

PAGE = 3


class LossyNode:
    """A node whose topic loses what one says; its journal loses nothing but what was removed."""

    def __init__(self) -> None:
        self.first = 1
        self.journal: list[Any] = []
        self.history = 'one'
        self.asked = 0

    def happen(self, *lost: bool) -> None:
        """Let events happen; those that are lost do not come on the topic."""
        for is_lost in lost:
            message = SimpleNamespace(seq=len(self.journal) + 1, history=self.history)
            self.journal.append(message)
            if not is_lost:
                self._event(message)

    def tell_status(self) -> None:
        self._status(self.status())

    def forget(self) -> None:
        """Start again with another journal."""
        self.journal = []
        self.history += ' more'

    def on_event(self, callback: Callable[[Any], None]) -> None:
        self._event = callback

    def on_status(self, callback: Callable[[CellStatus], object]) -> None:
        self._status = callback

    def status(self) -> CellStatus:
        return statuses.status(seq=len(self.journal), history=self.history)

    def events_after(self, seq: int) -> Any:
        self.asked += 1
        after = max(seq, self.first - 1)
        page = self.journal[after : after + PAGE]
        return SimpleNamespace(first_seq=self.first, events=page, history=self.history)


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


def test_what_was_fetched_and_comes_then_is_told_once(node: LossyNode) -> None:
    follower = EventFollower(node, None)
    node.happen(True, True)  # the first is that of a node that has come back with its journal
    node.tell_status()
    assert new(follower) == [6, 7]
    for message in node.journal[5:]:
        node._event(message)
    assert new(follower) == []


@pytest.mark.parametrize('lost', [(False, False), (True, False), (True, True)])
@pytest.mark.parametrize('more', [0, 9])
def test_a_node_with_another_journal_is_followed_from_its_beginning(
    node: LossyNode, lost: tuple[bool, bool], more: int
) -> None:
    told: list[str] = []
    follower = EventFollower(node, None, on_anew=told.append)
    node.forget()
    node.happen(*lost, *[True] * more)
    node.tell_status()
    assert new(follower) == list(range(1, 3 + more))
    assert told == ['one more']


def test_a_fetch_that_the_next_node_answers(node: LossyNode) -> None:
    follower = EventFollower(node, None)
    node.happen(True, False)
    node.forget()
    node.happen(True, True, True)
    assert new(follower) == []
    node.tell_status()
    assert new(follower) == [1, 2, 3]


def test_last_words_of_a_node_that_is_gone_begin_nothing_anew(node: LossyNode) -> None:
    told: list[str] = []
    follower = EventFollower(node, None, on_anew=told.append)
    late = SimpleNamespace(seq=6, history=node.history)
    node.forget()
    node.happen(False)
    assert new(follower) == [1]
    node._event(late)
    node._status(statuses.status(seq=6, history=late.history))
    assert new(follower) == []
    node.tell_status()
    node.happen(False)
    assert new(follower) == [2]
    assert told == ['one more']


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
