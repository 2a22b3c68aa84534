"""Journals are read while they are written, by whoever may, and never changed by it."""

from __future__ import annotations

import shutil
import sqlite3
from collections.abc import Iterator
from pathlib import Path

import pytest
from fakes.journal_reading import journal_reading
from fakes.line import Line
from fakes.long_journal import LongRun

from bt_orchestrator.base.errors import JournalUnusable
from bt_orchestrator.engine.runtime.housekeeping import AT_REST
from bt_orchestrator.model.keeping.records import Wanted
from bt_orchestrator.store.shared import rows
from bt_orchestrator.store.sqlite.records import SqliteRecords
from bt_orchestrator.view.report.reading import Reading

SCHEMA_1 = Path(__file__).parents[3] / 'data' / 'journal_schema_1.sqlite3'


@pytest.fixture
def run(tmp_path: Path) -> Iterator[LongRun]:
    """Give a run with one job, whose journal is open."""
    long_run = LongRun(tmp_path / 'journal.sqlite3', Line(faults={'a2': '#2=abort'}), keep_jobs=1)
    long_run.job('J1', 1)
    yield long_run
    long_run.kill()


@pytest.fixture
def reader(run: LongRun) -> Iterator[Reading]:
    with journal_reading(run.store._path) as opened:
        yield opened


def test_page_ends_after_many_rows_or_bytes(
    reader: Reading, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever is wanted, nobody reads for long at one go, and all is found all the same."""
    wishes = [
        Wanted(job=job, newest_first=newest_first)
        for job in (None, 'J9')
        for newest_first in (True, False)
    ]
    whole = [list(reader.each(wanted)) for wanted in wishes]
    monkeypatch.setattr(rows, 'LOOKED_AT', 4)
    assert [list(reader.each(wanted)) for wanted in wishes] == whole
    page = reader.page(Wanted(job='J9'))
    assert (page.records, page.rest, page.is_last) == ([], Wanted(4, 'J9'), False)
    monkeypatch.setattr(rows, 'MOST_BYTES', 1)
    assert [list(reader.each(wanted)) for wanted in wishes] == whole
    assert len(reader.page(Wanted()).records) == 1


def test_a_file_that_is_no_journal(tmp_path: Path) -> None:
    with pytest.raises(JournalUnusable, match='there is no journal'):
        SqliteRecords(tmp_path / 'none')
    assert not (tmp_path / 'none').exists()
    (tmp_path / 'text').write_text('hello' * 1000)
    with pytest.raises(JournalUnusable, match='file is not a database'):
        SqliteRecords(tmp_path / 'text')
    sqlite3.connect(tmp_path / 'other').execute('CREATE TABLE a (b)').connection.close()
    with pytest.raises(JournalUnusable, match='no journal of an orchestrator'):
        SqliteRecords(tmp_path / 'other')


def test_an_older_journal_is_read_as_it_is(tmp_path: Path) -> None:
    path = Path(shutil.copy(SCHEMA_1, tmp_path / 'journal.sqlite3'))
    before = path.read_bytes()
    with journal_reading(path) as reader:
        assert len(list(reader.each(Wanted()))) == 156
        assert list(reader.summaries()) == []
    assert path.read_bytes() == before


def test_jobs_without_events_keep_their_summary(run: LongRun, reader: Reading) -> None:
    for name in ('J2', 'J3'):
        run.job(name, 2, _STATION_B)
        run.rest(AT_REST + 3)
    assert reader.records.extent().first_seq > 1
    fold = reader.jobs()
    jobs = list(fold.jobs.values())
    assert [(j.job, j.status, j.counts.packed, j.complete) for j in jobs] == [
        ('J1', 'completed', 1, False),
        ('J2', 'completed', 2, False),
        ('J3', 'completed', 2, True),
    ]
    assert list(jobs[2].items) == ['J3/1', 'J3/2']
    assert jobs[0].started is not None
    (alone,) = (job for job in reader.jobs('J3').jobs.values() if job.complete)
    assert alone == jobs[2]


_STATION_B = """
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2: [{id: work, @b2}]
  3: [{id: pack, @a3, qty_change: -1}]
"""
