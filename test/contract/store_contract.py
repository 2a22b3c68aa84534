"""What every journal does, whatever keeps it (see ports/journal.py: EventStore).

Subclass it and say how one is made.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest
from contract.written_events import events

from bt_orchestrator.base.errors import JournalFailed
from bt_orchestrator.model.events import Event
from bt_orchestrator.ports import EventStore


class EventStoreContract(ABC):
    """The contract of what an engine writes, and reads again."""

    @abstractmethod
    def make(self, folder: Path) -> EventStore:
        """Return a new journal; in a folder that was used, nothing of it may be known."""

    @abstractmethod
    def put_away(self, store: EventStore) -> None:
        """Let go of it."""

    @pytest.fixture
    def store(self, tmp_path: Path) -> Iterator[EventStore]:
        store = self.make(tmp_path)
        yield store
        self.put_away(store)

    def test_a_new_one_is_empty_and_whole(self, store: EventStore) -> None:
        assert list(store.read()) == []
        assert store.first_seq() == 1
        assert store.missing(0) == ''
        assert not store.is_restored
        assert list(store.snapshots()) == []
        assert store.beginning() is None

    def test_each_store_keeps_its_own_history(self, store: EventStore, tmp_path: Path) -> None:
        before = store.history
        store.append(events(1, 3))
        assert store.history == before != ''
        other = self.make(tmp_path / 'other')
        assert other.history != before
        self.put_away(other)

    def test_events_are_read_as_they_were_appended(self, store: EventStore) -> None:
        store.append(events(1, 1))
        store.append(events(2, 120))
        store.append(events(121, 123))
        assert list(store.read()) == events(1, 123)
        assert store.first_seq() == 1
        assert store.missing(123) == ''

    def test_some_of_them(self, store: EventStore) -> None:
        store.append(events(1, 20))
        assert list(store.read(15)) == events(16, 20)
        assert list(store.read(20)) == []
        assert list(store.read(25)) == []
        assert list(store.read(0, 3)) == events(1, 3)
        assert list(store.read(17, 9)) == events(18, 20)
        assert list(store.read(5, 0)) == []

    def test_more_than_fits_into_one_answer(self, store: EventStore) -> None:
        for first in range(1, 3001, 500):
            store.append(events(first, first + 499))
        assert list(store.read()) == events(1, 3000)
        assert list(store.read(after=100, most=2500)) == events(101, 2600)

    @pytest.mark.parametrize('again', [1, 10])
    def test_repeated_event_is_refused_with_its_batch(self, store: EventStore, again: int) -> None:
        """A second engine that goes on from the same event is stopped here."""
        store.append(events(1, 10))
        with pytest.raises(JournalFailed):
            store.append(events(again, again + 5))
        assert list(store.read()) == events(1, 10)
        store.append(events(11, 12))
        assert list(store.read()) == events(1, 12)

    @pytest.mark.parametrize('gap', [events(12, 13), [*events(11, 11), *events(13, 13)]])
    def test_an_append_that_leaves_a_gap_is_refused(
        self, store: EventStore, gap: Sequence[Event]
    ) -> None:
        store.append(events(1, 10))
        with pytest.raises(JournalFailed, match=r'event 1[23] cannot follow event 1[01]'):
            store.append(gap)
        assert list(store.read()) == events(1, 10)
        store.append(events(11, 12))
        assert list(store.read()) == events(1, 12)

    def test_a_new_one_begins_with_event_1(self, store: EventStore) -> None:
        with pytest.raises(JournalFailed, match='event 2 cannot follow event 0'):
            store.append(events(2, 3))
        store.append(events(1, 3))
        assert list(store.read()) == events(1, 3)

    def test_9_4_who_has_just_written_may_send_goals(self, store: EventStore) -> None:
        store.append(events(1, 3))
        assert store.may_command()

    def test_9_4_absence_is_unknown_before_first_look(self, store: EventStore) -> None:
        store.append(events(1, 3))
        assert store.absent_at(2) is None
        assert store.absent_at(9) is None
