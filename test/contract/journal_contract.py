"""What every journal does that outlives its orchestrator (see ports/journal.py: Journal).

Subclass it and say how one is opened, and how it is damaged.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Sequence
from contextlib import closing
from pathlib import Path
from typing import cast

import pytest
from contract.store_contract import EventStoreContract
from contract.written_events import events

from bt_orchestrator.base.errors import DamagedRecord, JournalFailed, JournalUnusable
from bt_orchestrator.model.events import Event, JobQueued
from bt_orchestrator.model.judging.used_ids import SealedIds, text_of
from bt_orchestrator.model.keeping.books import Books, KeptScript, KeptSlot, KeptState
from bt_orchestrator.ports import EventStore, Journal, Snapshot


class JournalContract(EventStoreContract):
    """The contract of what a next orchestrator finds."""

    @abstractmethod
    def make(self, folder: Path) -> Journal:
        """Open the journal in a folder; it is a new one if there is none."""

    @abstractmethod
    def spoil(self, folder: Path, seq: int) -> None:
        """Make the record of an event another one, as a damaged disk does; nobody has it open."""

    @abstractmethod
    def lose(self, folder: Path, first: int, last: int) -> None:
        """Take records away, as a damaged disk does; nobody has it open."""

    def put_away(self, store: EventStore) -> None:
        cast('Journal', store).close()

    @pytest.fixture
    def store(self, tmp_path: Path) -> Iterator[Journal]:
        with closing(self.make(tmp_path)) as store:
            yield store

    def test_append_tells_when_only_the_disk_is_left(self, store: Journal) -> None:
        durable: list[int] = []
        store.at_disk = lambda: durable.append(len(list(store.read())))
        store.append(events(1, 3))
        store.append(events(4, 4))
        assert durable == [0, 3]

    # --- the next one -----------------------------------------------------------------------

    def test_the_next_finds_what_was_appended(self, tmp_path: Path) -> None:
        history = self._written(tmp_path, 1, 30)
        with closing(self.make(tmp_path)) as store:
            assert store.history == history
            assert list(store.read()) == events(1, 30)
            assert store.missing(30) == ''
            store.append(events(31, 33))
            assert list(store.read(after=29)) == events(30, 33)
        with closing(self.make(tmp_path)) as store:
            assert (store.history, list(store.read())) == (history, events(1, 33))

    def test_a_second_orchestrator_is_kept_out(self, store: Journal, tmp_path: Path) -> None:
        with pytest.raises(JournalUnusable, match='in use by another orchestrator'):
            self.make(tmp_path)
        store.append(events(1, 2))
        assert list(store.read()) == events(1, 2)

    def test_9_4_who_looks_whether_it_leads_may_command(self, store: Journal) -> None:
        store.append(events(1, 2))
        store.renew()
        assert store.may_command()
        assert bool(store.epoch) is store.is_shared

    def test_9_4_shared_journal_gives_each_writer_higher_epoch(self, tmp_path: Path) -> None:
        epochs = []
        for _ in range(3):
            with closing(self.make(tmp_path)) as store:
                epochs.append(store.epoch)
        assert epochs == (sorted(set(epochs)) if store.is_shared else [0, 0, 0])

    # --- states to start from ---------------------------------------------------------------

    def test_states_are_there_for_the_next_newest_first(self, tmp_path: Path) -> None:
        with closing(self.make(tmp_path)) as store:
            store.append(events(1, 20))
            for seq in (10, 20):
                store.save(_state(seq))
            assert list(store.snapshots()) == [_state(20), _state(10)]
        with closing(self.make(tmp_path)) as store:
            assert list(store.snapshots()) == [_state(20), _state(10)]
            assert store.beginning() is None

    def test_the_last_state_of_an_event_counts(self, store: Journal) -> None:
        store.append(events(1, 5))
        store.save(_state(5))
        store.save(_state(5, 'another program'))
        assert list(store.snapshots()) == [_state(5, 'another program')]

    def test_used_ids_stay_as_they_are(self, tmp_path: Path) -> None:
        part, other = SealedIds(text_of(['A', 'B'], {})), SealedIds(text_of(['C'], {}))
        with closing(self.make(tmp_path)) as store:
            store.append(events(1, 1))
            assert store.lacking([part, other]) == [part, other]
            store.keep_used(part)
            assert store.lacking([part, other]) == [other]
        with closing(self.make(tmp_path)) as store:
            assert store.used_ids(part.digest) == part.text
            assert store.used_ids(other.digest) is None
            assert store.lacking([part, other]) == [other]

    # --- retention --------------------------------------------------------------------------

    def test_events_are_removed_only_before_beginning_state(self, tmp_path: Path) -> None:
        with closing(self.make(tmp_path)) as store:
            store.append(events(1, 20))
            assert not store.remove_batch(before=15)
            assert list(store.read()) == events(1, 20)
            store.begin_with(_state(9))
            assert list(store.read()) == events(1, 20)
            _remove(store, before=15)
            assert list(store.read(9)) == events(10, 20)
        with closing(self.make(tmp_path)) as store:
            assert (store.first_seq(), store.beginning()) == (10, _state(9))
            assert list(store.read()) == events(10, 20)
            store.begin_with(_state(20))
            _remove(store, before=21)
            assert (store.first_seq(), store.missing(20)) == (21, '')
            store.append(events(21, 22))
            assert list(store.read()) == events(21, 22)

    def test_live_and_kept_jobs_determine_first_needed_event(self, store: Journal) -> None:
        store.append([*_queued(1, 'A'), *_queued(2, 'B'), *_queued(3, 'C'), *events(4, 4)])
        assert store.first_needed(live=(), keep_jobs=3) == 0
        assert store.first_needed(live=(), keep_jobs=2) == 2
        assert store.first_needed(live=('A',), keep_jobs=1) == 1
        assert store.first_needed(live=('B', 'C'), keep_jobs=0) == 2
        assert store.first_needed(live=('C',), keep_jobs=1) == 2
        assert store.first_needed(live=(), keep_jobs=0) == 5

    # --- books --------------------------------------------------------------------------------

    def test_books_persist_and_newer_slot_replaces_older(self, tmp_path: Path) -> None:
        with closing(self.make(tmp_path)) as store:
            store.append(events(1, 20))
            assert store.booked() == 0
            store.keep_books(_books(store.history, 8, '{"n": 1}'))
            store.keep_books(_books(store.history, 12, '{"n": 2}'))
            assert store.booked() == 12
        with closing(self.make(tmp_path)) as store:
            assert store.booked() == 12

    def test_books_of_another_history_are_refused(self, store: Journal) -> None:
        store.append(events(1, 20))
        with pytest.raises(JournalFailed, match='another history'):
            store.keep_books(_books('another', 8, '{}'))
        assert store.booked() == 0

    def test_books_of_what_is_no_more_are_none(self, tmp_path: Path) -> None:
        with closing(self.make(tmp_path)) as store:
            store.append(events(1, 20))
            store.keep_books(_books(store.history, 10, '{}', stays=True))
            store.keep_books(_books(store.history, 20, '{}'))
        with closing(self.make(tmp_path)) as store:
            store.go_on_after(12)
            store.append(events(13, 25))
            assert store.booked() == 10

    # --- the next number --------------------------------------------------------------------

    def test_the_next_leaves_no_gap_either(self, tmp_path: Path) -> None:
        self._written(tmp_path, 1, 5)
        with closing(self.make(tmp_path)) as store:
            with pytest.raises(JournalFailed, match='event 8 cannot follow event 5'):
                store.append(events(8, 9))
            assert list(store.read()) == events(1, 5)
            store.append(events(6, 7))
            assert list(store.read()) == events(1, 7)

    def test_without_any_event_left_the_numbers_go_on(self, tmp_path: Path) -> None:
        with closing(self.make(tmp_path)) as store:
            store.append(events(1, 20))
            store.begin_with(_state(20))
            _remove(store, before=21)
        with closing(self.make(tmp_path)) as store:
            for wrong in (1, 20, 22):
                with pytest.raises(JournalFailed, match=f'event {wrong} '):
                    store.append(events(wrong, wrong))
            store.append(events(21, 22))
            assert list(store.read()) == events(21, 22)

    def test_journal_continues_from_state_whose_events_are_lost(self, tmp_path: Path) -> None:
        with closing(self.make(tmp_path)) as store:
            store.append(events(1, 20))
            store.save(_state(20))
        self.lose(tmp_path, 17, 20)
        with closing(self.make(tmp_path)) as store:
            with pytest.raises(JournalFailed, match='event 20 cannot follow event 16'):
                store.append(events(20, 20))
            store.append(events(21, 22))
            assert list(store.read(20)) == events(21, 22)

    # --- another history --------------------------------------------------------------------

    def test_another_history_begins_with_the_next_event(self, tmp_path: Path) -> None:
        old = self._written(tmp_path, 1, 20)
        with closing(self.make(tmp_path)) as store:
            store.go_on_after(12)
            assert store.history != old
            assert list(store.read()) == events(1, 12)
        with closing(self.make(tmp_path)) as store:  # nothing was written
            assert (store.history, list(store.read())) == (old, events(1, 20))
            store.go_on_after(12)
            with pytest.raises(JournalFailed, match='event 21 cannot follow event 12'):
                store.append(events(21, 21))
            store.append(events(13, 14))
            new = store.history
            assert list(store.read()) == events(1, 14)
        with closing(self.make(tmp_path)) as store:
            assert (store.history, list(store.read())) == (new, events(1, 14))
            assert store.missing(14) == ''

    def test_states_of_what_is_no_more_are_none(self, tmp_path: Path) -> None:
        with closing(self.make(tmp_path)) as store:
            store.append(events(1, 20))
            for seq in (10, 20):
                store.save(_state(seq))
        with closing(self.make(tmp_path)) as store:
            store.go_on_after(12)
            assert list(store.snapshots()) == [_state(10)]
            store.append(events(13, 25))
            assert list(store.snapshots()) == [_state(10)]

    # --- damage -----------------------------------------------------------------------------

    @pytest.mark.parametrize('how', ['spoil', 'lose'])
    def test_events_are_read_up_to_a_damage(self, tmp_path: Path, how: str) -> None:
        for seq in range(1, 21):
            self._written(tmp_path, seq, seq)
        self._damage(tmp_path, how, 7)
        with closing(self.make(tmp_path)) as store:
            read: list[Event] = []
            with pytest.raises(DamagedRecord) as damage:
                read.extend(store.read())
            assert read == events(1, 6)
            assert (damage.value.first, damage.value.last) == (7, 7)
            assert '14 events are missing' in store.missing(6)
            assert list(store.read(after=damage.value.last)) == events(8, 20)

    @pytest.mark.parametrize('how', ['spoil', 'lose'])
    def test_of_a_damaged_commit_nothing_is_read(self, tmp_path: Path, how: str) -> None:
        self._written(tmp_path, 1, 5)
        self._written(tmp_path, 6, 9)
        self._damage(tmp_path, how, 8)
        with closing(self.make(tmp_path)) as store:
            read: list[Event] = []
            with pytest.raises(DamagedRecord):
                read.extend(store.read())
            assert read == events(1, 5)

    @pytest.mark.parametrize(('first', 'last'), [(1, 4), (17, 20)], ids=['beginning', 'end'])
    def test_a_loss_at_either_end_is_noticed(self, tmp_path: Path, first: int, last: int) -> None:
        for seq in range(1, 21):
            self._written(tmp_path, seq, seq)
        self.lose(tmp_path, first, last)
        with closing(self.make(tmp_path)) as store:
            if first == 1:
                with pytest.raises(DamagedRecord, match='events 1 to 4 are not there'):
                    list(store.read())
            else:
                assert list(store.read()) == events(1, 16)
                assert '4 events are missing' in store.missing(16)

    def test_what_goes_on_after_a_damage_is_whole(self, tmp_path: Path) -> None:
        for seq in range(1, 11):
            self._written(tmp_path, seq, seq)
        self.spoil(tmp_path, 7)
        with closing(self.make(tmp_path)) as store:
            store.go_on_after(6)
            store.append(events(7, 8))
        with closing(self.make(tmp_path)) as store:
            assert (list(store.read()), store.missing(8)) == (events(1, 8), '')

    def _written(self, folder: Path, first: int, last: int) -> str:
        with closing(self.make(folder)) as store:
            store.append(events(first, last))
            return store.history

    def _damage(self, folder: Path, how: str, seq: int) -> None:
        if how == 'spoil':
            self.spoil(folder, seq)
        else:
            self.lose(folder, seq, seq)


def _remove(store: Journal, before: int) -> None:
    while store.remove_batch(before):
        pass


def _state(seq: int, stamp: str = 'program') -> Snapshot:
    return Snapshot(seq, stamp, f'{{"seq": {seq}}}')


def _queued(seq: int, job: str) -> Sequence[Event]:
    return [JobQueued(seq=seq, time=1.0, job=job, script='s', digest='d', quantity=1)]


def _books(history: str, seq: int, text: str, *, stays: bool = False) -> Books:
    slot = KeptSlot(0, seq * 1_000_000, seq, 1, text)
    state = KeptState(seq, seq * 1_000_000, seq, stays, 1, text)
    return Books(history, seq, True, [slot], [state], [KeptScript('digest', text)])
