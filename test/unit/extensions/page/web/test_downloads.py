"""The items of a job as files."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator, Sequence
from io import StringIO
from pathlib import Path

import pytest
from fakes.line import THREE, Line
from fakes.page_bench import PeopleBench
from fakes.profiles import examples
from fakes.stepped import Steps, drawn_steps, stepped
from fakes.virtual_run import VirtualRun
from hypothesis import given

from bt_orchestrator.extensions.page.web.archive import Archive, downloads
from bt_orchestrator.extensions.page.web.archive.archive import Look
from bt_orchestrator.extensions.page.web.archive.ended_jobs import job_record
from bt_orchestrator.extensions.page.web.archive.heard import HeardRecords
from bt_orchestrator.extensions.page.web.endpoint import Endpoint
from bt_orchestrator.model.codec import from_record
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.jobs.job_record import JobRecord
from bt_orchestrator.model.keeping.records import Extent, JobPlace, Summaries
from bt_orchestrator.ports import Records
from bt_orchestrator.ports.doors.following_door import Happened, Lost
from bt_orchestrator.store.memory import MemoryRecords, MemoryStore
from bt_orchestrator.view.report.csv_export import write_items


class Forgotten(HeardRecords):
    """Of job OLD a summary is left, and nothing of its items."""

    def summaries(
        self, after: JobPlace | None = None, most: int = 0, *, newest_first: bool = False
    ) -> Summaries:
        del after, most, newest_first
        old = JobRecord('OLD', 'boxes', 3, 1.0, status='completed', complete=False)
        return Summaries((old,), (), None)


class Bench(PeopleBench):
    """A page that reads records."""

    def __init__(self, folder: Path, records: Records) -> None:
        self._archive = Archive(None, lambda: records)  # type: ignore[arg-type]
        super().__init__(folder)

    def endpoints(self) -> Sequence[Endpoint]:
        return downloads.endpoints(self._archive)

    def close(self) -> None:
        self._archive.close()
        super().close()


@pytest.fixture(scope='module')
def run() -> VirtualRun:
    line = Line(3, faults={'a2': 'TASK_A#1=abort'})
    run = VirtualRun(line.cell, line.types)
    run.submit('WO-ä', line.script(THREE), 2)
    run.go()
    run.answer('retry')
    run.go()
    assert run.ended
    return run


@pytest.fixture
def bench(run: VirtualRun, tmp_path: Path) -> Iterator[Bench]:
    bench = Bench(tmp_path, Forgotten('', 0, [Happened(event) for event in run.store.read()]))
    yield bench
    bench.close()


def test_every_item_is_a_row_of_the_table(bench: Bench) -> None:
    answer = bench.browser().get('/api/jobs/WO-%C3%A4/items.csv')
    assert answer.status == 200
    assert answer.headers['content-type'].startswith('text/csv')
    named = "attachment; filename*=UTF-8''WO-%C3%A4-items.csv"
    assert answer.headers['content-disposition'] == named
    rows = list(csv.DictReader(StringIO(answer.body.decode(), newline='')))
    assert [(row['item'], row['how']) for row in rows] == [
        ('WO-ä/1', 'packed'),
        ('WO-ä/2', 'packed'),
    ]


def test_the_other_file_has_the_whole_record(bench: Bench) -> None:
    answer = bench.browser().get('/api/jobs/WO-%C3%A4/items.json')
    job = json.loads(answer.body)
    assert (job['job'], job['counts']['packed'], list(job['items'])) == (
        'WO-ä',
        2,
        ['WO-ä/1', 'WO-ä/2'],
    )
    assert [failure['reason'] for failure in job['failures']] == ['aborted']


def test_missing_items_give_no_empty_file(bench: Bench) -> None:
    browser = bench.browser()
    gone = browser.get('/api/jobs/OLD/items.csv')
    assert (gone.status, 'not kept any more' in gone.message) == (410, True)
    assert browser.get('/api/jobs/X/items.csv').status == 404


def test_incomplete_file_is_named_incomplete(run: VirtualRun, tmp_path: Path) -> None:
    events = list(run.store.read())
    kept = [Happened(event) for event in events[:-3]]
    bench = Bench(tmp_path, HeardRecords('', 0, [*kept, Lost(events[-3].seq, events[-1].seq)]))
    answer = bench.browser().get('/api/jobs/WO-%C3%A4/items.csv')
    assert 'items-incomplete.csv' in answer.headers['content-disposition']
    bench.close()


def test_the_record_of_an_item_is_a_document(bench: Bench) -> None:
    browser = bench.browser()
    answer = browser.get('/api/items/WO-%C3%A4/1/record.html')
    assert (answer.status, answer.headers['content-type']) == (200, 'text/html; charset=utf-8')
    named = "attachment; filename*=UTF-8''WO-%C3%A4-1.html"
    assert answer.headers['content-disposition'] == named
    text = answer.body.decode()
    assert 'Item record' in text
    assert 'it looked so' in text
    assert browser.get('/api/items/WO-%C3%A4/9/record.html').status == 404


@pytest.mark.parametrize(
    ('zone', 'words'),
    [('Asia/Tokyo', 'of Asia/Tokyo (UTC+09:00).'), ('Moon/Base', 'of this computer, UTC')],
)
def test_record_uses_time_zone_of_reader(bench: Bench, zone: str, words: str) -> None:
    answer = bench.browser().get(f'/api/items/WO-%C3%A4/1/record.html?zone={zone}')
    assert f'Times are those {words}' in answer.body.decode()


@examples(5, 300)
@given(drawn_steps())
def test_a_clock_that_is_set_changes_no_duration(run: VirtualRun, steps: Steps) -> None:
    events = [from_record(record) for record in run.records]
    assert taken_s(stepped(events, steps)) == pytest.approx(taken_s(events), abs=0.0011)


def taken_s(events: Sequence[Event]) -> list[float]:
    store = MemoryStore('a')
    store.append(events)
    look = Look(MemoryRecords(store), Extent('a', 1, len(events)))
    record = job_record(look, 'WO-\xe4')
    assert record is not None
    file = StringIO()
    write_items(record, file)
    return [float(row['seconds']) for row in csv.DictReader(StringIO(file.getvalue()))]
