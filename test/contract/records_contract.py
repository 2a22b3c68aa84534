"""What every reader of a journal does, whatever keeps it (see ports/records.py).

Subclass `RecordsContract`, or `KeptRecordsContract` where a journal outlives its orchestrator, and
say how one is made.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Protocol

import pytest
from contract.written_events import events

from bt_orchestrator.model.codec import to_text
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.jobs.job_record import JobRecord
from bt_orchestrator.model.keeping.books import KeptScript, KeptSlot, KeptState
from bt_orchestrator.model.keeping.records import Damage, JobPlace, Record, RecordPage, Wanted
from bt_orchestrator.ports import Records

LAST = 40


class Written(Protocol):
    """A journal that is written, and read by somebody else."""

    @property
    def records(self) -> Records:
        """What is tested."""

    def append(self, events: Sequence[Event]) -> None:
        """Write events, as an orchestrator does."""

    def close(self) -> None:
        """Put everything away."""


class Kept(Written, Protocol):
    """One that can be kept short, and be damaged."""

    def save(self, ended: Sequence[JobRecord]) -> None:
        """Write what stays of jobs that ended."""

    def remove(self, before: int) -> None:
        """Remove the first events by right."""

    def spoil(self, seq: int) -> None:
        """Make the record of an event another one, as a damaged disk does."""

    def lose(self, first: int, last: int) -> None:
        """Take records away, as a damaged disk does."""

    def book(self, slots: Sequence[KeptSlot], states: Sequence[KeptState]) -> None:
        """Write books, with a script `digest`."""

    def spoil_book(self, begin_us: int) -> None:
        """Damage a slot, the newest state, and the scripts."""

    def spoil_summary(self, job: str) -> None:
        """Damage what is kept of a job."""


OLDEST_FIRST = (
    Wanted(),
    Wanted(after_seq=7),
    Wanted(before_seq=30),
    Wanted(after_seq=7, before_seq=12),
    Wanted(job='WO-1'),
    Wanted(job='WO-9'),
    Wanted(events=('job.started',)),
    Wanted(events=('job.started', 'item.placed')),
    Wanted(events=('job.',)),
    Wanted(events=('*.completed',)),
    Wanted(since=5.0),
    Wanted(until=5.0),
    Wanted(since=3.0, until=9.5),
    Wanted(after_seq=2, job='WO-2', events=('job.', 'item.'), since=2.0, until=15.0),
)
WANTED = (*OLDEST_FIRST, *(replace(wanted, newest_first=True) for wanted in OLDEST_FIRST))
both_ways = pytest.mark.parametrize('newest_first', [False, True], ids=['oldest', 'newest'])


class RecordsContract(ABC):
    """The contract of reading."""

    @abstractmethod
    def make(self, folder: Path) -> Written:
        """Return an empty journal, open for who reads it."""

    @pytest.fixture
    def written(self, tmp_path: Path) -> Iterator[Written]:
        written = self.make(tmp_path)
        written.append(events(1, 20))
        written.append(events(21, LAST))
        yield written
        written.close()

    def test_an_empty_journal_has_one_empty_page(self, tmp_path: Path) -> None:
        with _closing(self.make(tmp_path)) as written:
            assert written.records.extent()[1:] == (1, 0)
            page = written.records.page(Wanted())
            assert (list(page.records), list(page.damage), page.is_last) == ([], [], True)
            assert not written.records.summaries().jobs
            written.append(events(1, 3))
            assert _seqs(written.records.page(page.rest)) == [1, 2, 3]

    def test_extent_and_pages_are_of_one_history(self, written: Written) -> None:
        extent, page = written.records.extent(), written.records.page(Wanted())
        assert (extent.first_seq, extent.last_seq) == (1, LAST)
        assert (page.history, page.first_seq) == (extent.history, 1)

    def test_records_are_as_they_were_written(self, written: Written) -> None:
        page = written.records.page(Wanted())
        assert page.records == [Record(event.seq, to_text(event)) for event in events(1, LAST)]
        assert page.is_last
        assert not page.damage

    def test_what_is_wanted_comes_in_order(self, written: Written) -> None:
        for wanted in WANTED:
            expected = [
                Record(event.seq, to_text(event))
                for event in events(1, LAST)
                if wanted.takes(event.event, getattr(event, 'job', None), event.time)
                and wanted.after_seq < event.seq < (wanted.before_seq or LAST + 1)
            ]
            page = written.records.page(wanted)
            assert page.records == (expected[::-1] if wanted.newest_first else expected), wanted
            assert page.is_last
            assert not page.damage

    @pytest.mark.parametrize('most', [1, 2, 7])
    def test_pages_put_together_are_the_whole(self, written: Written, most: int) -> None:
        for wanted in WANTED:
            pages = list(_pages(written.records, wanted, most))
            assert all(len(page.records) <= most for page in pages)
            whole = written.records.page(wanted).records
            assert [record for page in pages for record in page.records] == whole, wanted

    def test_a_cursor_may_be_used_again(self, written: Written) -> None:
        rest = written.records.page(Wanted(job='WO-1'), 3).rest
        assert written.records.page(rest, 3) == written.records.page(rest, 3)

    def test_later_records_follow_the_last_page(self, written: Written) -> None:
        rests = [written.records.page(wanted).rest for wanted in OLDEST_FIRST]
        assert not any(written.records.page(rest).records for rest in rests)
        written.append(events(LAST + 1, LAST + 15))
        for wanted, rest in zip(OLDEST_FIRST, rests, strict=True):
            after = [seq for seq in _seqs(written.records.page(wanted)) if seq > LAST]
            assert _seqs(written.records.page(rest)) == after, wanted

    def test_a_number_that_is_not_there_yet(self, written: Written) -> None:
        page = written.records.page(Wanted(after_seq=LAST + 10))
        assert (list(page.records), list(page.damage), page.is_last) == ([], [], True)
        written.append(events(LAST + 1, LAST + 12))
        assert _seqs(written.records.page(page.rest)) == [LAST + 11, LAST + 12]

    def test_summaries_of_nothing(self, written: Written) -> None:
        page = written.records.summaries()
        assert (list(page.jobs), list(page.damage), page.rest) == ([], [], None)


class KeptRecordsContract(RecordsContract):
    """Also of what is removed, summed up and damaged."""

    @abstractmethod
    def make(self, folder: Path) -> Kept:
        """Return an empty journal, open for who reads it."""

    @pytest.fixture
    def written(self, tmp_path: Path) -> Iterator[Kept]:
        written = self.make(tmp_path)
        written.append(events(1, 20))
        written.append(events(21, LAST))
        yield written
        written.close()

    # --- what is removed and summed up ------------------------------------------------------

    def test_what_was_removed_by_right_is_no_damage(self, written: Kept) -> None:
        written.remove(before=11)
        assert written.records.extent()[1:] == (11, LAST)
        page = written.records.page(Wanted(after_seq=3))
        assert (page.first_seq, _seqs(page), page.damage) == (11, list(range(11, LAST + 1)), [])
        newest = written.records.page(Wanted(newest_first=True))
        assert (_seqs(newest)[-1], newest.damage, newest.is_last) == (11, [], True)

    def test_all_may_be_removed(self, written: Kept) -> None:
        written.remove(before=LAST + 1)
        assert written.records.extent().first_seq == LAST + 1
        assert written.records.page(Wanted()).damage == []
        written.append(events(LAST + 1, LAST + 1))
        assert _seqs(written.records.page(Wanted())) == [LAST + 1]

    def test_jobs_that_ended_come_as_they_were_queued(self, written: Kept) -> None:
        jobs = [_job('b', 1.0), _job('a', 2.0), _job('c', 2.0), _job('a', 0.5)]
        written.save(jobs)
        page = written.records.summaries()
        assert list(page.jobs) == [jobs[3], jobs[0], jobs[1], jobs[2]]
        assert page.rest is None
        newest = written.records.summaries(newest_first=True)
        assert list(newest.jobs) == list(reversed(page.jobs))

    def test_last_saved_job_summary_is_kept(self, written: Kept) -> None:
        written.save([_job('a', 1.0)])
        written.save([replace(_job('a', 1.0), quantity=9)])
        assert [job.quantity for job in written.records.summaries().jobs] == [9]

    @both_ways
    @pytest.mark.parametrize('most', [1, 2, 5, 6])
    def test_summaries_come_in_pages(self, written: Kept, newest_first: bool, most: int) -> None:
        written.save([_job(f'J{n}', n / 2 // 1) for n in range(5)])
        jobs: list[JobRecord] = []
        after: JobPlace | None = None
        while True:
            page = written.records.summaries(after, most, newest_first=newest_first)
            assert len(page.jobs) <= most
            jobs += page.jobs
            after = page.rest
            if after is None:
                break
        assert jobs == list(written.records.summaries(newest_first=newest_first).jobs)
        assert len(jobs) == 5

    def test_a_damaged_summary_is_told_and_left_out(self, written: Kept) -> None:
        written.save([_job(f'J{n}', float(n)) for n in range(3)])
        written.spoil_summary('J1')
        page = written.records.summaries()
        assert [job.job for job in page.jobs] == ['J0', 'J2']
        (damage,) = page.damage
        assert "the summary of job 'J1' is damaged" in damage.what
        assert damage.number == 1

    def test_past_moment_starts_from_an_earlier_state(self, written: Kept) -> None:
        assert written.records.state_before(LAST) is None
        written.save([])
        written.append(events(LAST + 1, LAST + 5))
        for seq, expected in ((LAST - 1, None), (LAST, LAST), (LAST + 5, LAST)):
            state = written.records.state_before(seq)
            assert (state and state.seq) == expected
        written.remove(before=LAST + 4)
        kept = written.records.state_before(LAST + 5)
        assert kept is not None
        assert kept.seq == LAST + 3
        assert written.records.state_before(LAST - 1) is None

    # --- books --------------------------------------------------------------------------------

    def test_slots_come_in_pages_and_by_period(self, written: Kept) -> None:
        assert not written.records.booked(-(1 << 62), 1 << 62).slots
        written.book(_slots(5, 7), [_state(7, 70, stays=False)])
        first = written.records.booked(-(1 << 62), 1 << 62, 2)
        assert [slot.begin_us for slot in first.slots] == [0, 10]
        assert first.rest_us is not None
        rest = written.records.booked(first.rest_us, 1 << 62)
        assert (list(rest.slots), rest.rest_us) == (_slots(5, 7)[2:], None)
        for begin, end, expected in (
            (15, 30, [10, 20]),
            (10, 11, [10]),
            (20, 20, []),
            (55, 99, []),
        ):
            page = written.records.booked(begin, end)
            assert [slot.begin_us for slot in page.slots] == expected
        newest = written.records.booked(-(1 << 62), 1 << 62, 2, newest_first=True)
        assert [slot.begin_us for slot in newest.slots] == [40, 30]

    def test_last_state_stays_until_newer_state_comes(self, written: Kept) -> None:
        assert written.records.book_state(1 << 62) is None
        written.book([], [_state(3, 30, stays=True), _state(7, 70, stays=False)])
        written.book([], [_state(9, 90, stays=False)])
        expected = ((1 << 62, 9), (90, 9), (89, 3), (30, 3), (29, None))
        for moment, seq in expected:
            state = written.records.book_state(moment)
            assert (state and state.seq) == seq, moment
        assert written.records.book_state(50, first_seq=4) is None

    def test_books_outlive_their_source_events(self, written: Kept) -> None:
        states = [_state(3, 30, stays=True), _state(12, 70, stays=True)]
        written.book(_slots(5, 7), [*states, _state(20, 90, stays=False)])
        written.remove(before=10)
        assert list(written.records.booked(0, 50).slots) == _slots(5, 7)
        assert written.records.book_state(50) is None, 'nobody can go on from there'
        assert written.records.book_script('digest') == KeptScript('digest', '{}')
        written.remove(before=30)
        last_state = written.records.book_state(1 << 62)
        assert last_state == _state(20, 90, stays=False), 'the next books go on from it'

    def test_damaged_books_are_told_and_left_out(self, written: Kept) -> None:
        written.book(_slots(5, 7), [_state(3, 30, stays=True), _state(7, 70, stays=False)])
        written.spoil_book(20)
        page = written.records.booked(0, 50)
        assert [slot.begin_us for slot in page.slots] == [0, 10, 30, 40]
        (damage,) = page.damage
        assert 'the account from 1970-01-01 00:00 UTC on is damaged' in damage.what
        state = written.records.book_state(1 << 62)
        assert state is not None
        assert state.seq == 3
        assert written.records.book_script('digest') is None

    # --- what is damaged --------------------------------------------------------------------

    @pytest.mark.parametrize(
        ('first', 'last', 'words'),
        [
            (9, 9, 'the record of event 9 is not there'),
            (9, 11, 'the records of events 9 to 11 are not there'),
        ],
    )
    def test_lost_records_are_told_whatever_is_wanted(
        self, written: Kept, first: int, last: int, words: str
    ) -> None:
        wholes = [_whole(written.records, wanted).records for wanted in WANTED]
        written.lose(first, last)
        for wanted, whole in zip(WANTED, wholes, strict=True):
            for most in (1, 1000):
                kept = _whole(written.records, wanted, most)
                assert kept.records == [row for row in whole if not first <= row.seq <= last]
                (damage,) = kept.damage
                assert words in damage.what
                assert damage.number == last + 1 - first

    def test_a_damaged_record_is_told_whatever_is_wanted(self, written: Kept) -> None:
        wholes = [_whole(written.records, wanted).records for wanted in WANTED]
        written.spoil(10)
        for wanted, whole in zip(WANTED, wholes, strict=True):
            kept = _whole(written.records, wanted)
            assert kept.records == [record for record in whole if record.seq != 10]
            (damage,) = kept.damage
            assert 'the record of event 10 is damaged' in damage.what
            assert damage.number == 1

    @both_ways
    @pytest.mark.parametrize(
        ('first', 'last'), [(1, 2), (LAST - 1, LAST)], ids=['beginning', 'end']
    )
    def test_records_lost_at_either_end_are_told(
        self, written: Kept, newest_first: bool, first: int, last: int
    ) -> None:
        written.lose(first, last)
        kept = _whole(written.records, Wanted(newest_first=newest_first))
        assert sum(damage.number for damage in kept.damage) == 2
        assert len(kept.records) == LAST - 2


def _slots(number: int, seq: int) -> list[KeptSlot]:
    return [KeptSlot(10 * n, 10 * n + 10, seq, 1, f'{{"n": {n}}}') for n in range(number)]


def _state(seq: int, now_us: int, *, stays: bool) -> KeptState:
    return KeptState(seq, now_us, seq, stays, 1, '{"a": 7}')


class _Whole:
    """All pages together."""

    def __init__(self, pages: Sequence[RecordPage]) -> None:
        self.records = [record for page in pages for record in page.records]
        self.damage: Sequence[Damage] = [damage for page in pages for damage in page.damage]


def _whole(records: Records, wanted: Wanted, most: int = 1000) -> _Whole:
    return _Whole(list(_pages(records, wanted, most)))


def _pages(records: Records, wanted: Wanted, most: int) -> Iterator[RecordPage]:
    for _ in range(2 * LAST):
        page = records.page(wanted, most)
        yield page
        if page.is_last:
            return
        wanted = page.rest
    pytest.fail('no page was the last one')


def _seqs(page: RecordPage) -> list[int]:
    return [record.seq for record in page.records]


def _job(name: str, queued: float) -> JobRecord:
    return JobRecord(name, 'script', 3, queued, status='completed', complete=False)


@contextmanager
def _closing(written: Written) -> Iterator[Written]:
    try:
        yield written
    finally:
        written.close()
