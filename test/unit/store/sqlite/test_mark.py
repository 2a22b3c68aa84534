"""The mark beside a journal: that events are missing is noticed, whatever became of them."""

from __future__ import annotations

import logging
import os
import shutil
import sqlite3
from pathlib import Path

import pytest

from bt_orchestrator.base.errors import JournalFailed, JournalUnusable
from bt_orchestrator.model.events import Event, JobStarted
from bt_orchestrator.ports import Snapshot
from bt_orchestrator.store.shared.mark import Reached, mark_of, read_mark, write_mark
from bt_orchestrator.store.sqlite.restoring import bring_back
from bt_orchestrator.store.sqlite.store import SqliteStore


def events(first: int, last: int) -> list[Event]:
    return [JobStarted(seq=n, time=n / 2, job=f'WO-{n}') for n in range(first, last + 1)]


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / 'journal.sqlite3'


def beside(path: Path, ending: str) -> Path:
    return path.with_name(path.name + ending)


def killed(path: Path, last: int) -> Path:
    """Leave a journal whose log has its newest events, as a killed process does."""
    written = path.with_name('written')
    store = SqliteStore(written)
    store.append(events(1, 10))
    store.close()
    store = SqliteStore(written)
    store.append(events(11, last))
    for ending in ('', '-wal', '-mark'):
        shutil.copy(beside(written, ending), beside(path, ending))
    store.close()
    return path


def missing(path: Path, after: int) -> str:
    store = SqliteStore(path)
    try:
        return store.missing(after)
    finally:
        store.close()


def test_it_says_how_far_the_journal_is_written(path: Path) -> None:
    store = SqliteStore(path)
    assert not mark_of(path).exists()
    for last in (3, 4):
        store.append(events(last - 2 if last == 3 else 4, last))
        assert read_mark(mark_of(path)) == Reached(store.history, last, last / 2)
    assert store.missing(4) == ''
    store.close()
    assert missing(path, 4) == ''


def test_unwritten_events_are_not_in_the_mark(path: Path) -> None:
    store = SqliteStore(path)
    store.append(events(1, 3))
    with pytest.raises(JournalFailed):
        store.append(events(3, 4))
    assert read_mark(mark_of(path)) == Reached(store.history, 3, 1.5)
    store.close()


def test_a_log_that_is_gone_is_noticed(path: Path) -> None:
    killed(path, 40)
    assert missing(path, 40) == ''
    beside(path, '-wal').unlink()
    assert missing(path, 10) == (
        '30 events are missing: event 40 of 1970-01-01 00:00:20 UTC had been written'
    )


def test_missing_journal_is_not_treated_as_new(path: Path) -> None:
    killed(path, 40)
    path.unlink()
    beside(path, '-wal').unlink()
    with pytest.raises(
        JournalUnusable, match=r'is missing: .*-mark says .* up to event 40'
    ) as caught:
        SqliteStore(path)
    assert 'move journal.sqlite3-mark away to begin with a new one' in str(caught.value)
    assert not path.exists()
    beside(path, '-mark').unlink()
    assert missing(path, 0) == ''


def test_another_journal_in_its_place_is_noticed(path: Path) -> None:
    killed(path, 40)
    store = SqliteStore(path.with_name('other'))
    store.append(events(1, 50))
    store.close()
    shutil.copy(path.with_name('other'), path)
    beside(path, '-wal').unlink()
    assert 'is of another journal' in missing(path, 50)
    assert 'written here up to event 40' in missing(path, 50)


@pytest.mark.parametrize('seq', [7, 40])
def test_what_comes_after_a_loss_is_another_history(path: Path, seq: int) -> None:
    killed(path, 40)
    beside(path, '-wal').unlink()
    before = path.read_bytes()
    store = SqliteStore(path)
    old = store.history
    store.go_on_after(10)
    assert store.history != old
    assert path.read_bytes() == before  # until the first write
    store.append(events(11, 11 + seq))
    assert list(store.read()) == events(1, 11 + seq)
    assert read_mark(mark_of(path)) == Reached(store.history, 11 + seq, (11 + seq) / 2)
    store.close()
    again = SqliteStore(path)
    assert (again.history, again.missing(11 + seq)) == (store.history, '')
    again.close()


def test_an_older_mark_is_no_loss(path: Path) -> None:
    killed(path, 40)
    store = SqliteStore(path)
    write_mark(mark_of(path), Reached(store.history, 12, 6.0))
    store.close()
    assert missing(path, 40) == ''


@pytest.mark.parametrize('damage', ['empty', 'cut', 'flip', 'folder', 'long'])
def test_a_damaged_mark_is_told_and_made_again(
    path: Path, damage: str, caplog: pytest.LogCaptureFixture
) -> None:
    killed(path, 40)
    mark = mark_of(path)
    whole = bytearray(mark.read_bytes())
    whole[30] ^= 4
    texts = {'empty': b'', 'cut': bytes(whole[:50]), 'flip': bytes(whole), 'long': b'x' * 10_000}
    if damage == 'folder':
        mark.unlink()
        mark.mkdir()
    else:
        mark.write_bytes(texts[damage])
    store = SqliteStore(path)
    warnings = [record.message for record in caplog.records if record.levelno == logging.WARNING]
    assert store.missing(40) == ''
    assert any('-mark' in words and 'would not be noticed' in words for words in warnings)
    store.append(events(41, 41))  # it stops nothing
    store.close()
    if damage != 'folder':
        assert read_mark(mark) == Reached(store.history, 41, 20.5)


def test_removed_mark_is_created_again(path: Path, caplog: pytest.LogCaptureFixture) -> None:
    store = SqliteStore(path)
    store.append(events(1, 5))
    mark_of(path).unlink()
    store.append(events(6, 6))
    store.save(Snapshot(6, 'stamp', '{}'))
    assert read_mark(mark_of(path)) == Reached(store.history, 6, 3.0)
    assert 'was taken away, and is made again' in caplog.text
    store.close()


def test_copy_has_no_mark_but_restored_journal_does(path: Path) -> None:
    killed(path, 40)
    copy = path.with_name('copy')
    database = sqlite3.connect(path)
    database.execute('VACUUM INTO ?', (str(copy),))
    database.close()
    assert 'may be missing' in missing(copy, 40)  # unless it is restored
    assert not beside(copy, '-mark').exists()
    done = bring_back(copy, path, move_aside=True)
    assert read_mark(mark_of(path)) == Reached(done.history, 40, 20.0)
    assert missing(path, 40) == ''
    assert done.aside is not None
    assert beside(done.aside, '-mark').exists()


def test_a_journal_of_an_older_program_gets_one(path: Path) -> None:
    shutil.copy(Path(__file__).parents[3] / 'data' / 'journal_schema_1.sqlite3', path)
    store = SqliteStore(path)
    assert store.missing(156) == ''
    store.append(events(157, 157))
    assert read_mark(mark_of(path)) == Reached(store.history, 157, 78.5)
    store.close()


def test_it_costs_no_fsync_a_commit(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    synced: list[int] = []
    monkeypatch.setattr(os, 'fsync', synced.append)
    store = SqliteStore(path)
    for n in range(1, 20):
        store.append(events(n, n))
    assert synced == []
    store.close()
    assert len(synced) == 1
