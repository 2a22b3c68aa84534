"""Books are made before retention removes what they are made of; failures only postpone it."""

from __future__ import annotations

import json
import logging
from contextlib import closing
from pathlib import Path

import pytest
from fakes.kept_books import BooksAtOnce, book_all
from fakes.line import Line
from fakes.long_journal import LongRun

from bt_orchestrator.base.child_process import ChildFailed
from bt_orchestrator.engine.runtime import housekeeping
from bt_orchestrator.engine.runtime.writers import WritesAtOnce, Written
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.keeping.books import Books
from bt_orchestrator.store.sqlite.records import SqliteRecords
from bt_orchestrator.store.sqlite.store import SqliteStore
from bt_orchestrator.view.report.account.account import Account, account, of_job, whole
from bt_orchestrator.view.report.account.losses import Loss
from bt_orchestrator.view.report.account.period import Period
from bt_orchestrator.view.report.account.plain import account_plain
from bt_orchestrator.view.report.reading import Reading

LINE = Line()


@pytest.fixture(autouse=True)
def soon_at_rest(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let one quiet moment be rest enough, so that a job is looked after when it has ended."""
    monkeypatch.setattr(housekeeping, 'AT_REST', 1)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / 'journal.sqlite3'


class NoBooks(BooksAtOnce):
    """Fails as long as it is told to."""

    fails = True

    def begin(self) -> Written[Books]:
        if not self.fails:
            return super().begin()
        self.begun += 1
        return WritesAtOnce().begin(self._fail)

    def _fail(self) -> Books:
        raise ChildFailed('no memory')


def told(path: Path, period: Period | None = None, cell: Cell | None = LINE.cell) -> Account:
    with closing(SqliteRecords(path)) as records:
        reading = Reading(records)
        return account(reading, period or whole(reading, 'J'), cell)


def figures(made: Account) -> str:
    """Return all that a report says, but what it was made from."""
    plain = account_plain(made)
    for name in ('made_from', 'notes'):
        del plain[name]
    return json.dumps(plain, indent=1)


def first_seq(path: Path) -> int:
    with closing(SqliteRecords(path)) as records:
        return records.extent().first_seq


def test_report_survives_retention_and_kills(
    tmp_path: Path,
) -> None:
    reports = []
    for keep_jobs in (housekeeping.KEEP_ALL, 1):
        path = tmp_path / f'journal {keep_jobs}'
        for number in range(6):
            run = LongRun(path, LINE, keep_jobs=keep_jobs, bookkeeping=BooksAtOnce(path))
            run.clock.call_at(700.0 * number, lambda: None)
            run.clock.advance()
            run.job(f'J{number}', quantity=2 + number)
            run.rest(20)
            run.kill()
        reports.append(told(path))
    every, removed = reports
    assert first_seq(tmp_path / 'journal 1') > 400
    assert not every.books.span
    assert removed.books.span
    assert figures(removed) == figures(every)
    assert removed.figures.produced == 27
    assert removed.figures.oee is not None


def test_old_job_is_reported_from_books(path: Path) -> None:
    run = LongRun(path, LINE, keep_jobs=0, bookkeeping=BooksAtOnce(path))
    run.job('A', quantity=4)
    run.job('B')
    run.rest(20)
    run.kill()
    with closing(SqliteRecords(path)) as records:
        made = account(Reading(records), of_job(Reading(records), 'A', 'J'), LINE.cell)
    assert made.figures.produced == 7, 'rounded to a quarter of an hour, in which B ended, too'
    assert any('rounded' in note for note in made.notes())


def test_failing_books_block_removal_and_warn_once(
    path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(housekeeping, 'TRY_AGAIN_AFTER', 50)
    bookkeeping = NoBooks(path)
    run = LongRun(path, LINE, keep_jobs=0, bookkeeping=bookkeeping)
    with caplog.at_level(logging.WARNING):
        for name in ('A', 'B', 'C', 'D'):
            run.job(name)
            run.rest(20)
    (warning,) = caplog.messages
    assert warning.startswith('the books of the account cannot be made (no memory)')
    assert bookkeeping.begun > 2
    assert first_seq(path) == 1
    bookkeeping.fails = False
    run.job('E')
    run.rest(20)
    assert first_seq(path) > 300
    run.kill()
    assert told(path).figures.produced == 15


def test_disk_stays_bounded_when_books_never_come(
    path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(housekeeping, 'WAIT_AT_MOST', 150)
    monkeypatch.setattr(housekeeping, 'TRY_AGAIN_AFTER', 50)
    bookkeeping = BooksAtOnce(path)
    run = LongRun(path, LINE, keep_jobs=1, bookkeeping=bookkeeping)
    for name in ('A', 'B'):
        run.job(name)
        run.rest(20)
    bookkeeping.begin = NoBooks(path).begin  # type: ignore[method-assign]
    with caplog.at_level(logging.WARNING):
        for name in ('C', 'D', 'E'):
            run.job(name)
            run.rest(20)
    assert first_seq(path) > 200
    run.kill()
    with closing(SqliteStore(path)) as store:
        book_all(store, path)
    made = told(path)
    assert made.figures.produced == 9, 'those of A, B and E'
    assert made.figures.times.lost_us[Loss.NOT_RECORDED] > 0


def test_books_are_made_after_set_event_count(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(housekeeping, 'BOOKS_EVERY', 100)
    bookkeeping = BooksAtOnce(path)
    run = LongRun(path, LINE, bookkeeping=bookkeeping)
    run.job('A', quantity=30)
    seq = run.orchestrator.state.seq
    assert 2 <= bookkeeping.begun <= seq / 100
    assert seq - run.store.booked() < 200
    run.kill()
