"""Reading a journal to its end, and on, with what cannot be read told once."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
from contract.written_events import events

from bt_orchestrator.model.keeping.records import RecordPage, Wanted
from bt_orchestrator.ports import Snapshot
from bt_orchestrator.store.sqlite.records import SqliteRecords
from bt_orchestrator.store.sqlite.store import SqliteStore
from bt_orchestrator.view.report.reading import Reading


@pytest.fixture
def store(tmp_path: Path) -> Iterator[SqliteStore]:
    with closing(SqliteStore(tmp_path / 'journal.sqlite3', synchronous='NORMAL')) as store:
        store.append(events(1, 20))
        yield store


@pytest.fixture
def messages() -> list[str]:
    return []


@pytest.fixture
def reading(store: SqliteStore, messages: list[str]) -> Iterator[Reading]:
    with closing(SqliteRecords(store._path)) as records:
        yield Reading(records, messages.append)


def seqs(page: RecordPage) -> list[int]:
    return [record.seq for record in page.records]


def test_what_comes_is_followed(store: SqliteStore, reading: Reading, messages: list[str]) -> None:
    pages = reading.pages(Wanted(job='WO-1'))
    assert seqs(next(pages)) == [1, 4, 10, 13, 16, 19]
    assert seqs(next(pages)) == []
    store.append(events(21, 30))
    assert seqs(next(pages)) == [25, 28]
    assert not messages


def test_another_history_is_read_from_its_beginning(
    store: SqliteStore, reading: Reading, messages: list[str]
) -> None:
    """Other events stand under numbers that were told already."""
    pages = reading.pages(Wanted(after_seq=18), is_continued=True)
    assert seqs(next(pages)) == [19, 20]
    store.go_on_after(15)
    store.append(events(16, 17))
    page = next(pages)
    assert seqs(page) == list(range(1, 18))
    assert page.history == store.history
    assert messages == [f'the journal goes on as history {store.history}; from its beginning:']


@pytest.mark.parametrize(('wanted', 'gap'), [(Wanted(4), '5 to 9'), (Wanted(), '1 to 9')])
def test_what_was_removed_meanwhile_is_told(
    store: SqliteStore, reading: Reading, messages: list[str], wanted: Wanted, gap: str
) -> None:
    store.begin_with(Snapshot(9, 'stamp', '{}'))
    store.remove_batch(10)
    assert seqs(next(reading.pages(wanted, is_continued=True))) == list(range(10, 21))
    assert messages == [f'events {gap} are not in the journal any more']
    assert reading.lost == 0


def test_who_begins_anew_misses_nothing(
    store: SqliteStore, reading: Reading, messages: list[str]
) -> None:
    store.begin_with(Snapshot(9, 'stamp', '{}'))
    store.remove_batch(10)
    assert seqs(next(reading.pages(Wanted()))) == list(range(10, 21))
    assert not messages


def test_a_damage_is_told_and_counted_once(
    store: SqliteStore, reading: Reading, messages: list[str]
) -> None:
    store._database.execute('DELETE FROM events WHERE seq IN (7, 8, 20)')
    for _ in range(2):
        assert len(list(reading.each(Wanted()))) == 17
        assert len(messages) == 2
        assert reading.lost == 3


@pytest.mark.parametrize('most', [0, 1, 5])
def test_so_many_at_most(reading: Reading, most: int) -> None:
    assert [record.seq for record in reading.each(Wanted(), most)] == list(range(1, most + 1))
