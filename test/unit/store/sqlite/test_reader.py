"""Journals are read while they are written, by whoever may, and never changed by it."""

from __future__ import annotations

import json
import shutil
import sqlite3
from collections.abc import Iterator
from pathlib import Path

import pytest
from fakes.line import Line
from fakes.long_journal import LongRun

from bt_orchestrator.errors import JournalUnusable
from bt_orchestrator.model.codec import from_record
from bt_orchestrator.model.events import JobStarted
from bt_orchestrator.report.jobs import JobFold
from bt_orchestrator.runtime.housekeeping import AT_REST
from bt_orchestrator.store.sqlite import reader as reading
from bt_orchestrator.store.sqlite.reader import JournalReader, Wanted

SCHEMA_1 = Path(__file__).parents[3] / 'data' / 'journal_schema_1.sqlite3'


@pytest.fixture
def run(tmp_path: Path) -> Iterator[LongRun]:
    """Give a run with one job, whose journal is open."""
    found = LongRun(tmp_path / 'journal.sqlite3', Line(faults={'a2': '#2=abort'}), keep_jobs=1)
    found.job('J1', 1)
    yield found
    found.kill()


@pytest.fixture
def reader(run: LongRun) -> Iterator[JournalReader]:
    with JournalReader(run.store._path) as opened:
        yield opened


def seqs(reader: JournalReader, **wanted: object) -> list[int]:
    return [seq for seq, _ in reader.records(Wanted(**wanted))]  # type: ignore[arg-type]


def names(reader: JournalReader, **wanted: object) -> set[str]:
    found = reader.records(Wanted(**wanted))  # type: ignore[arg-type]
    return {json.loads(text)['event'] for _, text in found}


def test_what_is_written_is_seen_by_who_reads(run: LongRun, reader: JournalReader) -> None:
    before = reader.last_seq()
    assert seqs(reader) == list(range(1, before + 1))
    run.store.append([JobStarted(seq=before + 1, job='J9')])
    assert seqs(reader, after_seq=before) == [before + 1]
    run.store._database.execute('DELETE FROM events WHERE seq > ?', (before,))


def test_filters(run: LongRun, reader: JournalReader) -> None:
    assert names(reader, events=('task.',)) == {'task.started', 'task.succeeded'}
    assert names(reader, events=('job.queued', 'item.placed')) == {'job.queued', 'item.placed'}
    assert names(reader, job='J2') == set()
    times = [json.loads(text)['time'] for _, text in reader.records(Wanted(since=1.0, until=3.0))]
    assert min(times) == 1.0
    assert max(times) == 3.0
    assert len(times) < len(seqs(reader))


def test_long_answers_come_in_pages(
    run: LongRun, reader: JournalReader, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = seqs(reader, events=('task.',))
    monkeypatch.setattr(reading, 'PAGE', 2)
    assert seqs(reader, events=('task.',)) == whole
    assert len(whole) > 4


def test_a_file_that_is_no_journal(tmp_path: Path) -> None:
    with pytest.raises(JournalUnusable, match='there is no journal'):
        JournalReader(tmp_path / 'none')
    assert not (tmp_path / 'none').exists()
    (tmp_path / 'text').write_text('hello' * 1000)
    with pytest.raises(JournalUnusable, match='file is not a database'):
        JournalReader(tmp_path / 'text')
    sqlite3.connect(tmp_path / 'other').execute('CREATE TABLE a (b)').connection.close()
    with pytest.raises(JournalUnusable, match='no journal of an orchestrator'):
        JournalReader(tmp_path / 'other')


def test_an_older_journal_is_read_as_it_is(tmp_path: Path) -> None:
    path = Path(shutil.copy(SCHEMA_1, tmp_path / 'journal.sqlite3'))
    before = path.read_bytes()
    with JournalReader(path) as reader:
        assert len(seqs(reader)) == 156
        assert reader.summaries() == []
    assert path.read_bytes() == before


def test_what_is_left_of_jobs_whose_events_are_gone(run: LongRun, reader: JournalReader) -> None:
    for name in ('J2', 'J3'):
        run.job(name, 2, _STATION_B)
        run.rest(AT_REST + 3)
    assert reader.first_seq() > 1
    fold = JobFold(reader.summaries())
    for _, text in reader.records(Wanted()):
        fold.follow(from_record(json.loads(text)))
    jobs = list(fold.jobs.values())
    assert [(j.job, j.status, j.counts.packed, j.complete) for j in jobs] == [
        ('J1', 'completed', 1, False),
        ('J2', 'completed', 2, False),
        ('J3', 'completed', 2, True),
    ]
    assert list(jobs[2].items) == ['J3/1', 'J3/2']
    assert jobs[0].started is not None


_STATION_B = """
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2: [{id: work, @b2}]
  3: [{id: pack, @a3, qty_change: -1}]
"""
