"""Books where the journal, or what is asked of it, is not as usual."""

from __future__ import annotations

import sqlite3
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path

import pytest
from fakes.day import at
from fakes.hand_made_shift import the_day
from fakes.kept_books import book_all

from bt_orchestrator.model import events as e
from bt_orchestrator.ports import Snapshot
from bt_orchestrator.store.sqlite.records import SqliteRecords
from bt_orchestrator.store.sqlite.store import SqliteStore
from bt_orchestrator.view.report.account import booked
from bt_orchestrator.view.report.account.account import Account, account, whole
from bt_orchestrator.view.report.account.losses import Loss
from bt_orchestrator.view.report.account.period import Period
from bt_orchestrator.view.report.account.planned import US, Planned, us_of
from bt_orchestrator.view.report.account.total import Times
from bt_orchestrator.view.report.reading import Reading

EVENTS = the_day().events
LAST = EVENTS[-1].seq


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / 'journal'


def write(path: Path, events: Sequence[e.Event], *, before: int = 0) -> None:
    """Write a journal with books, and remove the events before one."""
    with closing(SqliteStore(path, synchronous='NORMAL')) as store:
        store.append(events)
        book_all(store, path)
        if before:
            store.begin_with(Snapshot(before, '', '{}'))
            while store.remove_batch(before):
                pass


def change(path: Path, statement: str) -> None:
    with closing(sqlite3.connect(path, isolation_level=None)) as database:
        database.execute(statement)


def told(path: Path, period: Period | None = None) -> tuple[Account, list[str]]:
    messages: list[str] = []
    with closing(SqliteRecords(path)) as records:
        reading = Reading(records, messages.append)
        return account(reading, period or whole(reading, 'J'), None), messages


def times(path: Path) -> Times:
    return told(path)[0].figures.times


def span(begin: str, end: str) -> Period:
    return Period.all_planned('p', us_of(at(begin)), us_of(at(end)))


def damage_the_slot_of_ten(path: Path) -> None:
    begin = us_of(at('10:00'))
    change(path, f"UPDATE book_slots SET slot = '{{}}' WHERE begin_us = {begin}")


def test_damaged_slot_is_reported_and_rebuilt_from_events(path: Path) -> None:
    write(path, EVENTS)
    whole_times = times(path)
    damage_the_slot_of_ten(path)
    actual, logs = told(path)
    assert actual.figures.times == whole_times
    assert actual.source.unreadable == 1
    assert [line for line in logs if 'the account from 2026-05-18 10:00 UTC on is damaged' in line]


def test_damaged_slot_without_events_is_not_recorded(path: Path) -> None:
    write(path, EVENTS, before=LAST)
    expected = times(path).planned
    damage_the_slot_of_ten(path)
    actual, _ = told(path)
    assert actual.figures.times.planned == expected
    quarter = 15 * 60 * US
    assert actual.figures.times.lost_us[Loss.NOT_RECORDED] == quarter


def test_books_of_other_version_are_reported_and_rebuilt(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, other = tmp_path / 'journal', tmp_path / 'other'
    write(other, EVENTS)
    with monkeypatch.context() as newer:
        newer.setattr(booked, 'BOOKS_VERSION', booked.BOOKS_VERSION + 1)
        write(path, EVENTS)
    actual, messages = told(path)
    assert (actual.figures.times, actual.books.span) == (times(other), ())
    assert len(messages) == 1
    assert 'those of another version' in messages[0]
    with closing(SqliteStore(path)) as store:
        book_all(store, path, 100, messages.append)
    actual, messages = told(path)
    assert (actual.figures.times, messages) == (times(other), [])
    assert actual.books.span


def test_report_names_what_books_without_causes_lack(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as older:
        older.setattr(booked, 'BOOKS_VERSION', booked.WITHOUT_CAUSES)
        write(path, EVENTS, before=LAST)
    actual, messages = told(path)
    shown = actual.figures
    assert (messages, shown.produced, shown.good) == ([], 539, 521)
    assert (shown.first_pass, shown.first_pass_yield) == (None, None)
    assert shown.mtbf_us(shown.times.repairs[0]) is None
    assert any('books of an older program: first-pass yield' in note for note in actual.notes())


@pytest.mark.parametrize(
    ('begin', 'end', 'rounded'),
    [
        ('10:00', '10:15', ('10:00', '10:15')),
        ('10:05', '11:00', ('10:00', '11:00')),
        ('10:10', '11:02', ('10:15', '11:00')),
        ('10:01', '10:03', ('10:00', '10:15')),
    ],
)
def test_edges_round_to_slots_where_events_are_gone(
    path: Path, begin: str, end: str, rounded: tuple[str, str]
) -> None:
    write(path, EVENTS, before=LAST)
    actual, _ = told(path, span(begin, end))
    exact, _ = told(path, span(*rounded))
    assert actual.figures.times == exact.figures.times
    assert actual.period.planned == exact.period.planned
    is_rounded = (begin, end) != rounded
    assert any('rounded to whole slots' in note for note in actual.notes()) == is_rounded
    assert sum(bar.us for bar in actual.figures.waterfall() if bar.loss is None) > 0


def test_where_events_are_kept_edges_are_exact(tmp_path: Path) -> None:
    with_books, without = tmp_path / 'with', tmp_path / 'without'
    write(with_books, EVENTS)
    with closing(SqliteStore(without)) as store:
        store.append(EVENTS)
    period = Period(
        'p',
        us_of(at('06:01')),
        us_of(at('13:59')),
        Planned.of(
            [(us_of(at('06:02')), us_of(at('09:10'))), (us_of(at('09:20')), us_of(at('13:31')))]
        ),
    )
    actual, expected = told(with_books, period)[0], told(without, period)[0]
    assert actual.books.span
    assert not expected.books.span
    first = actual.notes()[0]
    assert first.startswith('made from books of 2026-05-18')
    assert ' and events 2 to ' in first
    assert actual.figures.times == expected.figures.times


def test_books_follow_journal_continued_from_earlier_event(tmp_path: Path) -> None:
    """What was booked of the lost events is gone with them."""
    path, other = tmp_path / 'journal', tmp_path / 'other'
    cut = LAST // 2
    write(path, EVENTS)
    with closing(SqliteStore(path)) as store:
        book_all(store, path)  # takes in nothing new
    began = e.OrchestratorStarted(cell='c', digest='d')
    anew = [began.stamped(cut + 1, EVENTS[cut].time + 5000.0)]
    with closing(SqliteStore(path)) as store:
        store.go_on_after(EVENTS[cut - 1].seq)
        store.append(anew)
        book_all(store, path)
    write(other, [*EVENTS[:cut], *anew])
    assert times(path) == times(other)


def test_clock_jump_of_years_makes_one_slot(path: Path) -> None:
    node = e.OrchestratorStarted(cell='c', digest='d')
    write(path, [node.stamped(1, 10.0), node.stamped(2, at('06:00'))])
    with closing(sqlite3.connect(path)) as database:
        assert database.execute('SELECT count(*) FROM book_slots').fetchone()[0] <= 3
    assert times(path).lost_us == {Loss.NO_ORDER: us_of(at('06:00')) - 10 * US}
    year, _ = told(path, Period.all_planned('p', us_of(at('01:02')), us_of(at('03:04'))))
    assert year.figures.times.lost_us == {Loss.NO_ORDER: (2 * 60 + 2) * 60 * US}


def test_damaged_book_tables_do_not_stop_node(path: Path) -> None:
    write(path, EVENTS)
    change(path, 'DROP TABLE book_states')
    with closing(SqliteStore(path)) as store:
        assert store.booked() == 0
        store.go_on_after(LAST - 1)
        store.append([EVENTS[-1]])
        store.begin_with(Snapshot(LAST, '', '{}'))
        store.remove_batch(LAST)
        assert store.first_seq() == LAST
