"""What was heard over the door is read as a journal is."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from pathlib import Path
from typing import Any, cast

from contract.records_contract import RecordsContract, Written
from contract.written_events import events

from bt_orchestrator.base.errors import NodeUnreachable
from bt_orchestrator.extensions.page.web.archive.heard import Heard, HeardRecords
from bt_orchestrator.extensions.page.web.board import MOST_EVENTS_KEPT, Board
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.keeping.records import Extent, RecordPage, Wanted
from bt_orchestrator.ports import EventPage
from bt_orchestrator.ports.doors.doors import Doors
from bt_orchestrator.ports.doors.following_door import Happened, Lost

AT_ONCE = 7
"""Events of one answer of the node."""


class _Written:
    def __init__(self) -> None:
        self._entries: list[Happened | Lost] = []
        self.records = HeardRecords('a', 0, self._entries)

    def append(self, events: Sequence[Event]) -> None:
        self._entries += map(Happened, events)

    def close(self) -> None:
        self.records.close()


class TestHeardRecords(RecordsContract):
    def make(self, folder: Path) -> Written:
        return _Written()


class Node:
    """Tells its events by pages, as far as it has them."""

    def __init__(self, kept: Sequence[Event], first: int = 1, *, is_there: bool = True) -> None:
        self.kept = [event for event in kept if event.seq >= first]
        self.first = first
        self.is_there = is_there
        self.asked = 0

    async def events_after(self, seq: int, most: int = 0) -> EventPage:
        self.asked += 1
        await asyncio.sleep(0)
        if not self.is_there:
            raise NodeUnreachable('nobody is there')
        after = [event for event in self.kept if event.seq > seq]
        return EventPage('a', after[: most or AT_ONCE], self.first, self.kept[-1].seq)


def heard(node: Node, begun: int, *later: Happened | Lost) -> tuple[Extent, RecordPage]:
    """Return what a page knows that began after an event."""

    async def look() -> HeardRecords:
        board = Board()
        board.begin('a', begun)
        for entry in later:
            board.ring.add(entry)
        known = Heard(board, cast('Doors', cast('Any', node)))
        await known.records()
        return await known.records()

    records = asyncio.run(look())
    return records.extent(), records.page(Wanted())


def test_events_before_the_page_are_fetched_once() -> None:
    node = Node(events(1, 30))
    extent, page = heard(node, 30, *map(Happened, events(31, 33)))
    assert extent == Extent('a', 1, 33)
    assert [record.seq for record in page.records] == list(range(1, 34))
    assert node.asked == 5, '30 events by 7'


def test_what_the_node_has_removed_is_not_known() -> None:
    extent, page = heard(Node(events(1, 30), first=11), 30)
    assert extent.first_seq == 11
    assert [record.seq for record in page.records] == list(range(11, 31))
    assert page.damage == []


def test_a_silent_node_leaves_what_was_heard() -> None:
    node = Node(events(1, 30), is_there=False)
    extent, _ = heard(node, 30, *map(Happened, events(31, 33)))
    assert extent == Extent('a', 31, 33)


def test_a_node_that_was_silent_is_asked_again() -> None:
    node = Node(events(1, 30), is_there=False)

    async def looks() -> list[Extent]:
        board = Board()
        board.begin('a', 30)
        known = Heard(board, cast('Doors', cast('Any', node)))
        first = (await known.records()).extent()
        node.is_there = True
        return [first, (await known.records()).extent(), (await known.records()).extent()]

    assert asyncio.run(looks()) == [Extent('a', 31, 30), Extent('a', 1, 30), Extent('a', 1, 30)]
    assert node.asked == 6, 'once in vain, and 30 events by 7'


def test_what_is_lost_for_good_is_told() -> None:
    _, page = heard(Node(events(1, 3)), 3, Lost(4, 5), *map(Happened, events(6, 7)))
    assert [record.seq for record in page.records] == [1, 2, 3, 6, 7]
    (damage,) = page.damage
    assert (damage.what, damage.number) == ('the node has lost events 4 to 5 for good', 2)


def test_no_more_than_the_last_events_are_kept() -> None:
    records = asyncio.run(_many(MOST_EVENTS_KEPT + 10))
    assert records.extent() == Extent('a', 11 + 3, MOST_EVENTS_KEPT + 13)


async def _many(count: int) -> HeardRecords:
    board = Board()
    board.begin('a', count)
    node = Node(events(1, count))
    for event in events(count + 1, count + 3):
        board.ring.add(Happened(event))
    global_page = AT_ONCE * 1000
    node.events_after = _large(node, global_page)  # type: ignore[method-assign]
    known = Heard(board, cast('Doors', cast('Any', node)))
    return await known.records()


def _large(node: Node, most: int) -> Any:
    async def events_after(seq: int, _: int = 0) -> EventPage:
        return EventPage('a', node.kept[seq : seq + most], 1, node.kept[-1].seq)

    return events_after
