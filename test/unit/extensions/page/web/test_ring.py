from __future__ import annotations

import pytest

from bt_orchestrator.extensions.page.web import board as book_module
from bt_orchestrator.extensions.page.web.board import MOST_IN_ONE, Ring
from bt_orchestrator.model.events import JobHeld
from bt_orchestrator.ports.doors.following_door import Happened, Lost


def filled(*seqs: int, before: int = 0) -> Ring:
    ring = Ring(before)
    for seq in seqs:
        ring.add(Happened(JobHeld(seq=seq, job='J')))
    return ring


def told(lost: Lost | list[Happened]) -> object:
    if isinstance(lost, Lost):
        return (lost.first, lost.last)
    return [fact.event.seq for fact in lost]


def test_an_empty_ring_begins_where_it_was_told() -> None:
    ring = Ring(7)
    assert (ring.before, ring.last) == (7, 7)


def test_what_follows_an_event_is_told_in_order() -> None:
    ring = filled(8, 9, 10, before=7)
    assert told(ring.after(7)) == [8, 9, 10]
    assert told(ring.after(9)) == [10]
    assert ring.last == 10


def test_a_message_has_so_many_events_at_most() -> None:
    ring = filled(*range(1, 500))
    assert told(ring.after(3)) == list(range(4, 4 + MOST_IN_ONE))


def test_lost_events_are_told_at_their_place() -> None:
    ring = filled(1, 2)
    ring.add(Lost(3, 5))
    ring.add(Happened(JobHeld(seq=6, job='J')))
    assert told(ring.after(0)) == [1, 2]
    assert told(ring.after(2)) == (3, 5)
    assert told(ring.after(5)) == [6]


def test_the_oldest_go_when_there_are_too_many(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(book_module, 'MOST_EVENTS_KEPT', 16)
    ring = filled(*range(1, 101))
    assert 16 <= ring.last - ring.before <= 18
    assert told(ring.after(ring.before)) == list(range(ring.before + 1, 101))
