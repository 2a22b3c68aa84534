"""Whatever is lost between a node and its client, the client gets every event once, in order."""

from __future__ import annotations

from random import Random

import pytest
from contract.link_bench import Seen

from bt_orchestrator.model.events import Event, JobHeld
from bt_orchestrator.ports import EventPage
from bt_orchestrator.ports.following import MOST_AHEAD, Follower

PAGE = 3


class LossyNode:
    """A node whose topic loses what one says; its journal loses nothing but what was removed."""

    def __init__(self) -> None:
        self.first = 1
        self.journal: list[Event] = []
        self.history = 'one'
        self.asked = 0
        self.seen = Seen()
        self.happen(*[False] * 5, hears=False)

    def follow(self, after_seq: int | None = None, history: str = '') -> None:
        last = len(self.journal) if after_seq is None else after_seq
        self.follower = Follower(self.seen, history or self.history, last)

    def happen(self, *lost: bool, hears: bool = True) -> None:
        """Let events happen; those that are lost do not come on the topic."""
        for is_lost in lost:
            event = JobHeld(seq=len(self.journal) + 1, job='J')
            self.journal.append(event)
            if hears and not is_lost:
                self.follower.heard(self.history, event)

    def tell_status(self) -> None:
        self.follower.told(self.history, len(self.journal))

    def forget(self) -> None:
        """Start again with another journal."""
        self.journal = []
        self.history += ' more'

    def page(self, after: int) -> EventPage:
        after = max(after, self.first - 1)
        events = self.journal[after : after + PAGE]
        return EventPage(self.history, events, self.first, len(self.journal))

    def fetch(self) -> list[int]:
        """Answer whatever is asked for; returns the numbers that are known now."""
        while (after := self.follower.next_fetch()) is not None:
            self.asked += 1
            assert self.follower.next_fetch() is None, 'asked for once'
            self.follower.fetched(self.page(after))
        return self.seen.seqs


@pytest.fixture
def node() -> LossyNode:
    return LossyNode()


def test_from_now_on(node: LossyNode) -> None:
    node.follow()
    node.happen(False, False)
    assert node.seen.seqs == [6, 7], 'told at once'
    assert node.fetch() == [6, 7]
    assert node.asked == 0


def test_from_a_number_on(node: LossyNode) -> None:
    node.follow(1)
    node.happen(False)
    assert node.fetch() == [2, 3, 4, 5, 6]


def test_a_number_that_jumps_is_a_gap(node: LossyNode) -> None:
    node.follow()
    node.happen(False, True, True, False)
    assert node.seen.seqs == [6]
    assert node.fetch() == [6, 7, 8, 9]


def test_status_ahead_of_events_shows_gap(node: LossyNode) -> None:
    node.follow()
    node.happen(True, True)
    assert node.fetch() == []
    node.tell_status()
    assert node.fetch() == [6, 7]


def test_what_was_removed_is_said(node: LossyNode) -> None:
    node.follow(0)
    node.first = 3
    node.tell_status()
    assert node.fetch() == [3, 4, 5]
    assert node.seen.gaps == [(1, 2)]


def test_removed_events_are_reported_once(node: LossyNode) -> None:
    node.follow(2)
    node.first = 6
    node.tell_status()
    assert node.fetch() == []
    node.tell_status()
    node.happen(False)
    assert node.fetch() == [6]
    assert node.seen.gaps == [(3, 5)]


def test_event_fetched_and_received_is_handled_once(node: LossyNode) -> None:
    node.follow()
    node.happen(True, True)
    node.tell_status()
    assert node.fetch() == [6, 7]
    for event in node.journal[5:]:
        node.follower.heard(node.history, event)
    assert node.fetch() == [6, 7]


def test_what_is_heard_while_somebody_fetches(node: LossyNode) -> None:
    node.follow()
    node.happen(True, False)
    after = node.follower.next_fetch()
    assert after == 5
    page = node.page(after)
    node.happen(False, True, False)
    node.follower.fetched(page)
    assert node.fetch() == [6, 7, 8, 9, 10]


def test_failed_fetch_waits_for_sign_of_life(node: LossyNode) -> None:
    node.follow()
    node.happen(True, False)
    assert node.follower.next_fetch() == 5
    node.follower.not_fetched()
    assert node.fetch() == []
    node.tell_status()
    assert node.fetch() == [6, 7]


def test_journal_behind_its_status_is_not_polled(
    node: LossyNode,
) -> None:
    node.follow()
    node.follower.told(node.history, 9)
    assert node.fetch() == []
    assert node.asked == 1
    node.happen(False, False, True, False)
    assert node.fetch() == [6, 7, 8, 9]


def test_number_of_kept_early_events_is_limited(node: LossyNode) -> None:
    node.follow()
    node.happen(True, *[False] * (MOST_AHEAD + 10))
    assert node.fetch() == list(range(6, len(node.journal) + 1))


@pytest.mark.parametrize('lost', [(False, False), (True, False), (True, True)])
@pytest.mark.parametrize('more', [0, 9])
def test_new_journal_is_followed_from_its_beginning(
    node: LossyNode, lost: tuple[bool, bool], more: int
) -> None:
    node.follow()
    node.forget()
    node.happen(*lost, *[True] * more)
    node.tell_status()
    assert node.fetch() == list(range(1, 3 + more))
    assert node.seen.histories == ['one more']


def test_whoever_knows_another_journal_begins_anew(node: LossyNode) -> None:
    node.follow(57, 'none of these')
    node.tell_status()
    assert node.fetch() == [1, 2, 3, 4, 5]
    assert node.seen.histories == ['one']


def test_a_fetch_that_the_next_node_answers(node: LossyNode) -> None:
    node.follow()
    node.happen(True, False)
    node.forget()
    node.happen(True, True, True)
    assert node.fetch() == []
    node.tell_status()
    assert node.fetch() == [1, 2, 3]


def test_last_messages_of_old_journal_restart_nothing(node: LossyNode) -> None:
    node.follow()
    before = node.history
    node.forget()
    node.happen(False)
    node.follower.heard(before, JobHeld(seq=6, job='J'))
    node.follower.told(before, 6)
    assert node.fetch() == [1]
    node.tell_status()
    node.happen(False)
    assert node.fetch() == [1, 2]
    assert node.seen.histories == ['one more']


@pytest.mark.parametrize('seed', range(20))
def test_whatever_is_lost(node: LossyNode, seed: int) -> None:
    random = Random(seed)
    node.follow(0)
    for _ in range(30):
        node.happen(*(random.random() < 0.5 for _ in range(random.randint(0, 5))))
        if random.random() < 0.3:
            node.tell_status()
        if random.random() < 0.5:
            node.fetch()
    node.tell_status()
    assert node.fetch() == list(range(1, len(node.journal) + 1))
